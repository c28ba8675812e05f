#!/usr/bin/env python3
"""Measures Pinocchio, Crocoddyl and MuJoCo on the chains that lamprey_bench marches, then prints Lamprey's ratios to them.

usage: steps.py CHAINS LAMPREY
CHAINS and LAMPREY are what lamprey_bench wrote by --chains_out and --benchmark_out. tools/bench_peers.sh makes the virtual
environment, runs lamprey_bench and then this.

As in lamprey_bench: processor time, one thread, five repetitions of at least 0.1 s after a warm-up, least and median.
Loops over the nodes run inside the peers' own compiled code, but for Pinocchio's ABA and its derivatives, called node by
node. Where a Python call could weigh, an empty one of the same kind is measured too and taken off. Pinocchio's and Crocoddyl's
numbers are checked against each other and against MuJoCo's, so that all three surely move the same chain.
"""
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # read when the libraries are loaded

import json
import statistics
import sys
import time

REPETITIONS = 5
LEAST_SECONDS = 0.1
MOMENT_SCALE = 0.1  # of Lamprey's moments: under the whole, peers' Euler steps of 1 ms end in infinities from five bodies on

# Lamprey's benchmark : what it is divided by (of several peers' benchmarks the sum). A chain of N bodies is looked up as
# "NAME, N bodies"; NAME alone is the paper's chain of three.
RATIOS = (
    ("step, trapezoid", ("Pinocchio ABA",)),  # one evaluation of the accelerations: no step yet
    ("step, paper", ("Crocoddyl Euler value",)),
    ("step, trapezoid", ("Crocoddyl Euler value",)),
    ("step, trapezoid", ("Crocoddyl RK4 value",)),
    ("step, trapezoid", ("MuJoCo Euler step",)),
    ("step, trapezoid", ("MuJoCo RK4 step",)),
    ("step with tangent, trapezoid", ("Crocoddyl Euler value", "Crocoddyl Euler derivatives")),
    ("step with tangent, trapezoid", ("Crocoddyl RK4 value", "Crocoddyl RK4 derivatives")),
    ("step with tangent, trapezoid", ("MuJoCo Euler step", "MuJoCo Euler differences")),
)


class Chain:
    """A chain as lamprey_bench wrote it, its bodies in a vacuum: mass is the mean of M's diagonal, kg; inertia is J, kg m²."""

    def __init__(self, written):
        self.names = [body["name"] for body in written["bodies"]]
        self.masses = [sum(body["mass_matrix"][::4]) / 3.0 for body in written["bodies"]]
        self.inertias = [body["inertia_matrix"][::4] for body in written["bodies"]]
        self.joints = {joint["child"]: joint for joint in written["joints"]}
        self.time_step = written["time_step"]
        # N m, [steps][3 joints]; Lamprey's act on the parent, in its frame; peers' act on the child, in the child's frame
        self.moments = [[-MOMENT_SCALE * component for moment in node for component in moment]
                        for node in written["moments"][:-1]]
        self.steps = len(self.moments)

    def centre(self, i):
        """Mass centre of body i from its own joint, m, body frame; the root's joint is at its mass centre."""
        return [-x for x in self.joints[self.names[i]]["child_offset"]] if i else [0.0, 0.0, 0.0]

    def placement(self, i):
        """Joint of body i from its parent's joint, m, parent's frame."""
        joint = self.joints[self.names[i]]
        return [c + d for c, d in zip(self.centre(self.parent(i)), joint["parent_offset"])]

    def parent(self, i):
        return self.names.index(self.joints[self.names[i]]["parent"])


def repeated(call, calls=1):
    """Processor times of one call, µs, one for each repetition; call() makes so many of them."""
    call()
    loops, spent = 1, 0.0
    while spent < LEAST_SECONDS:
        if spent > 0.0:
            loops = max(loops + 1, int(1.2 * loops * LEAST_SECONDS / max(spent, 1e-3 * LEAST_SECONDS)))
        spent = ticks(call, loops)
    return [1e6 * ticks(call, loops) / (loops * calls) for _ in range(REPETITIONS)]


def ticks(call, loops):
    """Processor time of all threads, s."""
    begin = time.process_time_ns()
    for _ in range(loops):
        call()
    return 1e-9 * (time.process_time_ns() - begin)


class Results:
    """Times by (name, bodies), µs; prints a line for each as it comes."""

    def __init__(self):
        self.times = {}

    def add(self, name, bodies, times, overhead=None):
        """`overhead`: least time of an empty call of the same kind, µs; taken off."""
        if overhead is not None:
            times = [t - overhead for t in times]
        self.times[name, bodies] = times
        note = "" if overhead is None else f"  call {digits(overhead)} taken off"
        print(f"{f'{name}, {bodies} bodies':<49} {digits(min(times)):>10} {digits(statistics.median(times)):>10} us{note}",
              flush=True)


def digits(value):
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def pinocchio_model(pin, chain):
    """Free root, ball joints; the joint's name is what Crocoddyl knows a floating base by."""
    model, numbers = pin.Model(), []
    model.gravity = pin.Motion.Zero()
    for i, name in enumerate(chain.names):
        if i == 0:
            number = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
        else:
            at = pin.SE3(pin.SE3.Identity().rotation, vector(chain.placement(i)))
            number = model.addJoint(numbers[chain.parent(i)], pin.JointModelSpherical(), at, name)
        numbers.append(number)
        inertia = pin.Inertia(chain.masses[i], vector(chain.centre(i)), matrix(chain.inertias[i]))
        model.appendBodyToJoint(number, inertia, pin.SE3.Identity())
    return model


def vector(values):
    import numpy
    return numpy.array(values, dtype=float)


def matrix(diagonal):
    import numpy
    return numpy.diag(vector(diagonal))


def called(function, model, data, columns):
    """Calls a function of Pinocchio at every node."""
    def all_nodes():
        for column in columns:
            function(model, data, *column)
    return all_nodes


def measure_pinocchio(chain, motion, results):
    """RNEA, ABA and the derivatives of ABA at the motion's nodes, states [steps+1][q, v].

    ABA is called node by node: abaInParallel, whose loop is compiled, works in world axes, and there ABA of version 4.1.0 loses
    all its digits by 20 bodies, as rnea(aba(moments)) = moments shows. So do the derivatives; their time is measured still.
    """
    import numpy
    import pinocchio as pin

    bodies, model = len(chain.names), pinocchio_model(pin, chain)
    data = model.createData()
    columns = [(x[:model.nq].copy(), x[model.nq:].copy(), vector([0.0] * 6 + moments))
               for x, moments in zip(motion, chain.moments)]
    a = numpy.asfortranarray(numpy.array([pin.aba(model, data, *column).copy() for column in columns]).T)
    q, v, tau = (numpy.asfortranarray(numpy.array(part).T) for part in zip(*columns))
    pool, forces = pin.ModelPool(model, 1), numpy.zeros_like(v, order="F")
    results.add("Pinocchio RNEA", bodies, repeated(lambda: pin.rneaInParallel(1, pool, q, v, a, forces), chain.steps))
    assert numpy.allclose(forces, tau, rtol=0.0, atol=1e-6 * abs(tau).max()), "Pinocchio's RNEA and ABA do not agree"
    empty, nothing = pin.Model(), [(numpy.zeros(0),) * 3] * chain.steps
    for name, function in (("ABA", pin.aba), ("ABA derivatives", pin.computeABADerivatives)):
        overhead = min(repeated(called(function, empty, empty.createData(), nothing), chain.steps))
        results.add(f"Pinocchio {name}", bodies, repeated(called(function, model, data, columns), chain.steps), overhead)


def own_nodes(bodies):
    """How many of Crocoddyl's RK4 nodes get memory of their own, 0.9 MB each for 3 bodies, 36 MB for 20: below 2 GB in all."""
    return max(50, 1000 * 3**3 // bodies**3)


def crocoddyl_problem(crocoddyl, pin, chain, integrate, nodes, in_cache):
    """A problem of so many nodes; cost: half the moments' squares, and the end's distance to the start.

    in_cache: all nodes work in the memory of one, as Lamprey's steps do; else each has its own, as Crocoddyl's solvers need.
    """
    model = pinocchio_model(pin, chain)
    state = crocoddyl.StateMultibody(model)
    actuation = crocoddyl.ActuationModelFloatingBase(state)
    assert actuation.nu == model.nv - 6, "Crocoddyl drives other joints than meant"

    def dynamics(cost):
        costs = crocoddyl.CostModelSum(state, actuation.nu)
        costs.addCost("cost", crocoddyl.CostModelResidual(state, cost), 1.0)
        return crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs)

    running = integrate(dynamics(crocoddyl.ResidualModelControl(state, actuation.nu)), chain.time_step)
    end = integrate(dynamics(crocoddyl.ResidualModelState(state, state.zero(), actuation.nu)), 0.0)
    data = [[running.createData()] * nodes, end.createData()] if in_cache else []
    problem = crocoddyl.ShootingProblem(state.zero(), [running] * nodes, end, *data)
    problem.nthreads = 1
    return problem


def measure_crocoddyl(chain, results):
    """Value and derivatives of a node by Euler and RK4, and the backward pass; returns both motions, states [steps+1][q, v]."""
    import crocoddyl
    import numpy
    import pinocchio as pin

    def native(vectors):
        listed = crocoddyl.StdVec_VectorXs()
        listed.extend([numpy.array(v, dtype=float) for v in vectors])
        return listed

    def add(name, problem, states, nodes):
        u = native(chain.moments[:nodes])
        empty = min(repeated(lambda: solver.setCandidate(states, u, True), nodes))  # takes the nodes in, and no more
        results.add(f"Crocoddyl {name.format('value')}", bodies, repeated(lambda: problem.calc(states, u), nodes), empty)
        results.add(f"Crocoddyl {name.format('derivatives')}", bodies,
                    repeated(lambda: problem.calcDiff(states, u), nodes), empty)

    bodies, motions = len(chain.names), {}
    for name, integrate in (
            ("Euler", lambda dynamics, h: crocoddyl.IntegratedActionModelEuler(dynamics, h)),
            ("RK4", lambda dynamics, h: crocoddyl.IntegratedActionModelRK(dynamics, crocoddyl.RKType.four, h))):
        problem = crocoddyl_problem(crocoddyl, pin, chain, integrate, chain.steps, in_cache=True)
        solver = crocoddyl.SolverFDDP(problem)
        states = native(problem.rollout(native(chain.moments)))
        motions[name] = numpy.array([numpy.asarray(x) for x in states])
        assert numpy.isfinite(motions[name]).all(), "Crocoddyl's motion is not finite"
        add(name + " {}", problem, states, chain.steps)
    own = own_nodes(bodies)
    problem = crocoddyl_problem(crocoddyl, pin, chain, integrate, own, in_cache=False)
    solver = crocoddyl.SolverFDDP(problem)
    states = native(motions["RK4"][:own + 1])
    add("RK4 {}, own memory", problem, states, own)
    solver.setCandidate(states, native(chain.moments[:own]), True)
    solver.computeDirection(True)
    results.add("Crocoddyl Riccati", bodies, repeated(solver.backwardPass, own))
    return motions


def mujoco_text(chain, integrator):
    """The chain in MuJoCo's own words: no gravity, no contact, no geometry, motors about each ball joint's three axes."""
    def words(values):
        return " ".join(repr(float(x)) for x in values)

    def body(i):
        at = "0 0 0" if i == 0 else words(chain.placement(i))
        joint = "<freejoint/>" if i == 0 else f'<joint name="{chain.names[i]}" type="ball"/>'
        children = "".join(body(c) for c in range(1, len(chain.names)) if chain.parent(c) == i)
        return (f'<body pos="{at}">{joint}<inertial pos="{words(chain.centre(i))}" mass="{chain.masses[i]!r}" '
                f'diaginertia="{words(chain.inertias[i])}"/>{children}</body>')

    motors = "".join(f'<motor joint="{name}" gear="{gear} 0 0 0"/>'
                     for name in chain.names[1:] for gear in ("1 0 0", "0 1 0", "0 0 1"))
    return (f'<mujoco><compiler balanceinertia="true"/>'
            f'<option integrator="{integrator}" timestep="{chain.time_step!r}" gravity="0 0 0">'
            f'<flag contact="disable" constraint="disable"/></option>'
            f"<worldbody>{body(0)}</worldbody><actuator>{motors}</actuator></mujoco>")


def mujoco_model(mujoco, chain, integrator):
    """J is put in after compilation, which takes no inertia with fluid: its entries need not obey A + B >= C."""
    model = mujoco.MjModel.from_xml_string(mujoco_text(chain, integrator))
    model.body_inertia[1:] = chain.inertias
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    mujoco.mj_resetData(model, data)
    return model, data


def check_same_chain(mujoco, chain, model, data):
    """Accelerations from rest under the first moments are those of Pinocchio."""
    import numpy
    import pinocchio as pin

    data.ctrl[:] = chain.moments[1]
    mujoco.mj_forward(model, data)
    other = pinocchio_model(pin, chain)
    expected = pin.aba(other, other.createData(), pin.neutral(other), numpy.zeros(other.nv), vector([0.0] * 6 + chain.moments[1]))
    assert numpy.allclose(data.qacc, expected, rtol=1e-8, atol=1e-8 * abs(expected).max()), "MuJoCo's chain is not Pinocchio's"


def measure_mujoco(chain, motions, results):
    """A step by Euler and RK4 in the rollout that MuJoCo offers, and its Jacobian by differences."""
    import mujoco
    import numpy
    from mujoco import rollout

    bodies = len(chain.names)
    control = numpy.array(chain.moments)[None]
    for integrator in ("Euler", "RK4"):
        model, data = mujoco_model(mujoco, chain, integrator)
        check_same_chain(mujoco, chain, model, data)
        mujoco.mj_resetData(model, data)
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS
        start = numpy.zeros((1, mujoco.mj_stateSize(model, full)))
        mujoco.mj_getState(model, data, start[0], full)
        states = numpy.zeros((1, chain.steps, start.shape[1]))
        results.add(f"MuJoCo {integrator} step", bodies,
                    repeated(lambda: rollout.rollout(model, data, start, control, state=states), chain.steps))
        turning, expected = states[0, -1, 3 - model.nv:], motions[integrator][-1, 3 - model.nv:]  # rad/s, body frames
        assert numpy.allclose(turning, expected, rtol=0.0, atol=1e-3 * abs(expected).max()), "MuJoCo does not move as Crocoddyl"
        if integrator == "Euler":
            A = numpy.zeros((2 * model.nv, 2 * model.nv))
            B = numpy.zeros((2 * model.nv, model.nu))
            results.add("MuJoCo Euler differences", bodies,
                        repeated(lambda: mujoco.mjd_transitionFD(model, data, 1e-6, False, A, B, None, None)))


def lamprey_times(path):
    """Least processor times by benchmark, µs, from Google Benchmark's file."""
    unit = {"ns": 1e-3, "us": 1.0, "ms": 1e3, "s": 1e6}
    with open(path, encoding="utf-8") as stream:
        runs = json.load(stream)["benchmarks"]
    return {run["run_name"]: run["cpu_time"] * unit[run["time_unit"]] for run in runs if run.get("aggregate_name") == "min"}


def ratios(lamprey, peers, chain_lengths):
    """Rows of (Lamprey's benchmark, peers', {bodies: ratio of least times}); absent where Lamprey has no such chain."""
    for name, divisors in RATIOS:
        row = {}
        for bodies in chain_lengths:
            own = lamprey.get(f"{name}, {bodies} bodies", lamprey.get(name) if bodies == 3 else None)
            if own is not None:
                row[bodies] = own / sum(min(peers[divisor, bodies]) for divisor in divisors)
        yield name, " + ".join(divisors), row


def print_ratios(lamprey, results, chain_lengths):
    """Says which benchmarks of RATIOS lamprey_bench does not have; returns how many."""
    missing = []
    heading = "Lamprey / peer, least times (below 1: Lamprey is faster), bodies:"
    print(f"\n{heading:<86}" + "".join(f"{bodies:>8}" for bodies in chain_lengths))
    for name, divisors, row in ratios(lamprey, results.times, chain_lengths):
        if not row:
            missing.append(name)
            continue
        print(f"{name + ' / ' + divisors:<86}"
              + "".join(f"{row[bodies]:8.2f}" if bodies in row else f"{'-':>8}" for bodies in chain_lengths))
    if missing:
        print(f"steps.py: not measured by lamprey_bench: {'; '.join(sorted(set(missing)))}", file=sys.stderr)
    return len(missing)


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: steps.py CHAINS LAMPREY")
    with open(sys.argv[1], encoding="utf-8") as stream:
        chains = [Chain(written) for written in json.load(stream)]
    import crocoddyl
    import mujoco
    import pinocchio
    print(f"\nPinocchio {pinocchio.__version__}, Crocoddyl {crocoddyl.__version__}, MuJoCo {mujoco.__version__}, as PyPI has them"
          f"\nThe same chains in a vacuum: a body's mass is the mean of M's diagonal (peers have no mass matrix), its inertia J"
          f"\n{MOMENT_SCALE:g} of Lamprey's moments; what is measured does not depend on them"
          f"\nCrocoddyl's nodes share the memory of one node, so that it stays in cache; own memory: as its solvers need it"
          f"\n\n{'processor time, one thread':<49} {'least':>10} {'median':>10}", flush=True)
    results = Results()
    for chain in chains:
        motions = measure_crocoddyl(chain, results)
        measure_pinocchio(chain, motions["RK4"], results)
        measure_mujoco(chain, motions, results)
    missing = print_ratios(lamprey_times(sys.argv[2]), results, [len(chain.names) for chain in chains])
    sys.exit(1 if missing else 0)


if __name__ == "__main__":
    main()
