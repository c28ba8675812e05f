"""A nonlinear program whose functions are sums over stages, for Ipopt through CasADi.

CasADi's own way, differentiating one graph of the whole problem, takes twice the time. Here one stage is differentiated, as a
scalar expression graph, and mapped over all stages; Jacobian and Hessian are assembled from the stages' entries.
"""
import dataclasses
import hashlib
import os
import pathlib
import subprocess
import time

import casadi
import numpy

OPTIONS = {"tol": 1e-8, "max_iter": 400, "max_cpu_time": 30.0, "linear_solver": "mumps", "print_level": 0, "sb": "yes",
           "mumps_pivot_order": 0, "mumps_permuting_scaling": 0, "mumps_scaling": 0}  # half of MUMPS' time on these chains
COMPILER = ["cc", "-O1", "-shared", "-fPIC"]  # -O2 and -O3 take up to eight times as long to compile, for nothing and for a tenth


@dataclasses.dataclass
class Block:
    """Stages alike. function(z, p) → r; stage n reads variables[:, n] and adds r to rows[:, n]. At most one entry of r each."""

    function: casadi.Function
    variables: numpy.ndarray  # [size of z][stages], indices
    rows: numpy.ndarray  # [size of r][stages], indices
    parameters: numpy.ndarray  # [size of p][stages]


@dataclasses.dataclass
class Outcome:
    point: numpy.ndarray
    multiplier: numpy.ndarray
    iterations: int
    converged: bool
    message: str
    wall_seconds: float
    processor_seconds: float
    motion: object = None  # what the point stands for, in the words of who made the program


class Sum:
    """A sparse matrix from entries listed by row and column; those at one place are added."""

    def __init__(self, rows, columns, size):
        keys = numpy.concatenate(columns).astype(numpy.int64) * size[0] + numpy.concatenate(rows)
        unique, place = numpy.unique(keys, return_inverse=True)
        self.sparsity = casadi.Sparsity.triplet(*size, (unique % size[0]).tolist(), (unique // size[0]).tolist())
        added = casadi.Sparsity.triplet(len(unique), len(keys), place.tolist(), list(range(len(keys))))
        self.order = None if len(unique) < len(keys) else numpy.argsort(place).tolist()
        self.added = casadi.MX(casadi.DM(added, 1.0))

    def __call__(self, entries):
        entries = casadi.vertcat(*entries)
        return casadi.MX(self.sparsity, entries[self.order] if self.order else casadi.mtimes(self.added, entries))


class StageFunctions:
    """Value, Jacobian and Hessian of multiplier · value of a block's stages, as lists of entries."""

    def __init__(self, block, folder):
        self.block = block
        z, p = casadi.SX.sym("z", len(block.variables)), casadi.SX.sym("p", len(block.parameters))
        multiplier = casadi.SX.sym("multiplier", len(block.rows))
        r = casadi.cse(casadi.densify(block.function(z, p)))
        jacobian = casadi.cse(casadi.jacobian(r, z))
        gradient = casadi.cse(casadi.gradient(casadi.dot(multiplier, r), z))
        hessian = casadi.cse(casadi.triu(casadi.jacobian(gradient, z)))
        functions = [casadi.Function("r", [z, p], [r]), casadi.Function("J", [z, p], [r, entries_of(jacobian)]),
                     casadi.Function("H", [z, p, multiplier], [entries_of(hessian)])]
        if folder:
            functions = compiled(functions, folder)
        stages = block.variables.shape[1]
        self.value_function, self.jacobian_function, self.hessian_function = (f.map(stages) for f in functions)
        self.jacobian_places = self.places(jacobian, block.rows, block.variables)
        rows, columns = self.places(hessian, block.variables, block.variables)
        self.hessian_places = numpy.minimum(rows, columns), numpy.maximum(rows, columns)

    @staticmethod
    def places(matrix, rows, columns):
        """Global rows and columns of the entries of all stages, stage by stage."""
        at_row, at_column = matrix.sparsity().get_triplet()
        return rows[at_row].T.ravel(), columns[at_column].T.ravel()

    def seen(self, vector, indices):
        return casadi.reshape(vector[indices.T.ravel().tolist()], *indices.shape)

    def values(self, x):
        return casadi.vec(self.value_function(self.seen(x, self.block.variables), self.block.parameters))

    def jacobian(self, x):
        r, J = self.jacobian_function(self.seen(x, self.block.variables), self.block.parameters)
        return casadi.vec(r), casadi.vec(J)

    def hessian(self, x, multiplier):
        return casadi.vec(self.hessian_function(self.seen(x, self.block.variables), self.block.parameters,
                                                self.seen(multiplier, self.block.rows)))


def entries_of(matrix):
    return casadi.vertcat(*matrix.nonzeros())


def compiled(functions, folder):
    """The same functions as machine code, made by CasADi's C and the C compiler; found in the folder where made before."""
    generator = casadi.CodeGenerator("stage.c")
    for function in functions:
        generator.add(function)
    source = generator.dump()
    folder = pathlib.Path(folder)
    library = folder / f"{hashlib.sha256(source.encode()).hexdigest()[:16]}.so"
    if not library.exists():
        folder.mkdir(parents=True, exist_ok=True)
        text, unfinished = library.with_suffix(".c"), library.with_suffix(f".{os.getpid()}")
        text.write_text(source, encoding="ascii")
        subprocess.run([*COMPILER, "-o", unfinished, text], check=True)
        unfinished.rename(library)
    return [casadi.external(function.name(), str(library)) for function in functions]


class StagedProgram:
    """minimise ½ Σ weight x² subject to rows = 0; variables in `fixed` keep the value they start with.

    folder: where stage functions are compiled to; without, CasADi interprets them.
    """

    def __init__(self, weight, fixed, row_count, blocks, folder=None):
        self.fixed = fixed
        size = len(weight)
        x, p, factor = casadi.MX.sym("x", size), casadi.MX.sym("p", 0), casadi.MX.sym("factor")
        multiplier = casadi.MX.sym("multiplier", row_count)
        weighted = numpy.flatnonzero(weight)
        weights = casadi.DM(weight[weighted])
        f = 0.5 * casadi.dot(weights, x[weighted.tolist()] ** 2)
        stages = [StageFunctions(block, folder) for block in blocks]
        row_places = [block.rows.T.ravel() for block in blocks]
        rows_of = Sum(row_places, [0 * places for places in row_places], (row_count, 1))
        jacobian_of = Sum(*zip(*(s.jacobian_places for s in stages)), (row_count, size))
        hessian_of = Sum(*zip((weighted, weighted), *(s.hessian_places for s in stages)), (size, size))
        g = rows_of([s.values(x) for s in stages])
        values, entries = zip(*(s.jacobian(x) for s in stages))
        jacobian = casadi.Function("jac_g", [x, p], [rows_of(values), jacobian_of(entries)])
        hessian = casadi.Function("hess_lag", [x, p, factor, multiplier],
                                  [hessian_of([factor * weights] + [s.hessian(x, multiplier) for s in stages])])
        self.rows = casadi.Function("g", [x], [g])
        self.nlp, self.derivatives = {"x": x, "p": p, "f": f, "g": g}, {"jac_g": jacobian, "hess_lag": hessian}
        self.solvers = {}

    def solver(self, options):
        key = repr(sorted(options.items()))
        if key not in self.solvers:
            self.solvers[key] = casadi.nlpsol("solver", "ipopt", self.nlp, {
                **self.derivatives, "print_time": False, "no_nlp_grad": True, "ipopt": {**OPTIONS, **options}})
        return self.solvers[key]

    def solve(self, start, multiplier=None, options=None):
        """Times count the call of Ipopt alone, not the making of functions."""
        solver = self.solver(options or {})
        bound = numpy.full(len(start), numpy.inf)
        bound[self.fixed] = 0.0
        arguments = {"x0": start, "lbg": 0.0, "ubg": 0.0, "lbx": numpy.where(bound == 0.0, start, -bound),
                     "ubx": numpy.where(bound == 0.0, start, bound)}
        if multiplier is not None:
            arguments["lam_g0"] = multiplier
        wall, processor = time.perf_counter(), time.process_time()
        found = solver(**arguments)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        stats = solver.stats()
        return Outcome(numpy.array(found["x"]).ravel(), numpy.array(found["lam_g"]).ravel(), stats["iter_count"],
                       stats["success"], stats["return_status"], wall, processor)
