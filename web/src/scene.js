// The three-dimensional picture: ellipsoids, joints, a ghost of the start, the root's path, a grid.
import {
  Box3, BufferGeometry, DirectionalLight, DoubleSide, Float32BufferAttribute, Group, HemisphereLight, Line,
  LineBasicMaterial, LineLoop, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, OctahedronGeometry,
  PerspectiveCamera, PlaneGeometry, Plane, Quaternion, Scene, Sphere, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Motion } from "./motion.js";
import { body_color, color } from "./theme.js";

const FIELD_OF_VIEW = 28;
export const VIEWS = {
  "3-D": [-0.55, -1, 0.62], Top: [0, -1e-4, 1], Side: [0, -1, 0], Back: [-1, 0, 0],
};

const lines = (points) => new BufferGeometry().setAttribute("position", new Float32BufferAttribute(points, 3));

function ring(first, second) {
  const points = [];
  for (let k = 0; k < 72; ++k) {
    const angle = k * Math.PI / 36, point = [0, 0, 0];
    point[first] = 1.004 * Math.cos(angle);
    point[second] = 1.004 * Math.sin(angle);
    points.push(...point);
  }
  return lines(points);
}

// One swimmer in the picture; look: solid, faint (the other run) or ghost (the start).
class Swimmer {
  constructor(run, look) {
    this.motion = new Motion(run);
    this.group = new Group();
    this.look = look;
    const many = run.bodies.length > 40;
    const sphere = new SphereGeometry(1, many ? 20 : 48, many ? 14 : 32), rings = [ring(0, 1), ring(0, 2)];
    this.bodies = run.bodies.map((body) => {
      const mesh = new Mesh(sphere, this.material());
      mesh.scale.fromArray(body.semi_axes);
      if (look !== "ghost") for (const shape of rings) mesh.add(new LineLoop(shape, this.ring_material()));
      this.group.add(mesh);
      return mesh;
    });
    if (look !== "ghost") this.add_joints(run);
    this.recolor();
  }

  material() {
    if (this.look === "solid") return new MeshLambertMaterial();
    const opacity = this.look === "ghost" ? 0.13 : 0.38;
    return new MeshLambertMaterial({ transparent: true, opacity, depthWrite: false });
  }

  ring_material() {
    return new LineBasicMaterial({ transparent: true, opacity: this.look === "solid" ? 0.45 : 0.6 });
  }

  add_joints(run) {
    const smallest = Math.min(...run.bodies.map((body) => Math.min(...body.semi_axes)));
    const ball = new SphereGeometry(0.32 * smallest, 20, 14);
    this.joint_material = new MeshBasicMaterial();
    this.arm_material = new LineBasicMaterial();
    this.balls = run.joints.map(() => new Mesh(ball, this.joint_material));
    this.arms = run.joints.map(() => new Line(lines(new Array(9).fill(0)), this.arm_material));
    for (const arm of this.arms) arm.frustumCulled = false;
    if (run.joints.length) this.group.add(...this.balls, ...this.arms);
  }

  recolor() {
    this.bodies.forEach((mesh, i) => {
      mesh.material.color.set(body_color(i));
      for (const loop of mesh.children) loop.material.color.set(color("ring"));
    });
    if (this.joint_material) {
      this.joint_material.color.set(color("joint"));
      this.arm_material.color.set(color("joint"));
    }
  }

  place(time) {
    const { centres, turns, joint_points, joints } = this.motion.pose(time);
    this.bodies.forEach((mesh, i) => {
      mesh.position.copy(centres[i]);
      mesh.quaternion.copy(turns[i]);
    });
    if (!this.balls) return;
    joints.forEach((joint, j) => {
      this.balls[j].position.copy(joint_points[j]);
      const points = this.arms[j].geometry.attributes.position;
      [centres[joint.parent], joint_points[j], centres[joint.child]].forEach((p, k) => points.setXYZ(k, p.x, p.y, p.z));
      points.needsUpdate = true;
    });
  }
}

// Keep-outs and waypoints of a run, as far as they lie near its motion: `box`, of `radius`.
class Obstacles {
  constructor({ obstacles }, box, radius) {
    this.group = new Group();
    this.seen = [];  // points that the picture should hold
    this.face = new MeshLambertMaterial({ transparent: true, opacity: 0.3, depthWrite: false, side: DoubleSide });
    this.wide_face = this.face.clone();  // of a half-space: there is much of it
    this.wide_face.opacity = obstacles.half_space.length > 2 ? 0.06 : 0.14;  // through the walls of a tank one looks in
    this.edge = new LineBasicMaterial();
    this.mark = new MeshBasicMaterial({ depthTest: false, transparent: true });  // bodies pass waypoints with their middles
    const room = box.clone().expandByScalar(0.3 * radius);
    obstacles.sphere.forEach((sphere) => this.add_sphere(sphere, room));
    obstacles.half_space.forEach((half) => this.add_half_space(half, box, radius));
    const marker = new OctahedronGeometry(0.025 * radius);
    for (const { position } of obstacles.waypoint) {
      const mesh = new Mesh(marker, this.mark);
      mesh.position.fromArray(position);
      mesh.renderOrder = 3;
      this.group.add(mesh);
      this.seen.push(mesh.position);
    }
  }

  add_sphere({ centre, radius }, room) {
    const middle = new Vector3(...centre);
    if (!room.intersectsSphere(new Sphere(middle, radius))) return;
    const mesh = new Mesh(new SphereGeometry(radius, 64, 40), this.face);
    mesh.position.copy(middle);
    for (const [first, second] of [[0, 1], [0, 2], [1, 2]]) {
      const loop = new LineLoop(ring(first, second), this.edge);
      loop.scale.setScalar(radius);
      mesh.add(loop);
    }
    this.group.add(mesh);
    for (let axis = 0; axis < 3; ++axis) for (const side of [-1, 1]) {
      const end = new Vector3().setComponent(axis, side * radius).add(middle);
      this.seen.push(end.clamp(room.min, room.max));
    }
  }

  // A square of its face, as wide as the motion, with short strokes into what is forbidden.
  add_half_space({ point, normal }, box, radius) {
    const out = new Vector3(...normal), face = new Plane().setFromNormalAndCoplanarPoint(out, new Vector3(...point));
    const middle = box.getCenter(new Vector3());
    if (Math.abs(face.distanceToPoint(middle)) > 2 * radius) return;
    const half = 1.1 * radius, depth = 0.06 * radius, square = new Group(), strokes = [];
    square.add(new Mesh(new PlaneGeometry(2 * half, 2 * half), this.wide_face));
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => [x * half, y * half]);
    square.add(new LineLoop(lines(corners.flatMap(([x, y]) => [x, y, 0])), this.edge));
    corners.forEach(([x, y], n) => {
      const [next_x, next_y] = corners[(n + 1) % 4];
      for (let k = 0; k < 24; ++k) {
        const at = [x + (next_x - x) * k / 24, y + (next_y - y) * k / 24];
        strokes.push(...at, 0, ...at, -depth);
      }
    });
    square.add(new LineSegments(lines(strokes), this.edge));
    square.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), out));
    square.position.copy(face.projectPoint(middle, new Vector3()));
    this.group.add(square);
  }

  recolor() {
    this.face.color.set(color("keep-out"));
    this.wide_face.color.set(color("keep-out"));
    this.edge.color.set(color("keep-out"));
    this.mark.color.set(color("path"));
  }
}

// The tips of every body at some 40 times of the motion.
function tips(run) {
  const motion = new Motion(run), duration = motion.time[motion.time.length - 1], points = [];
  for (let k = 0; k <= 40; ++k) {
    motion.pose(duration * k / 40);
    run.bodies.forEach((body, i) => body.semi_axes.forEach((length, axis) => {
      for (const side of [-1, 1]) {
        const tip = new Vector3().setComponent(axis, side * length).applyQuaternion(motion.turns[i]);
        points.push(tip.add(motion.centres[i]));
      }
    }));
  }
  return points;
}

function round_step(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [1, 2, 5, 10].map((digit) => digit * power).find((step) => step >= length * 0.999);
}

function grid_lines(box, step) {
  const points = [], margin = step;
  const low = (axis) => Math.floor((box.min[axis] - margin) / step) * step;
  const high = (axis) => Math.ceil((box.max[axis] + margin) / step) * step;
  const z = box.min.z - 0.5 * step;
  for (let x = low("x"); x <= high("x") + 1e-6 * step; x += step) points.push(x, low("y"), z, x, high("y"), z);
  for (let y = low("y"); y <= high("y") + 1e-6 * step; y += step) points.push(low("x"), y, z, high("x"), y, z);
  return lines(points);
}

export class Picture {
  // Throws where the browser has no WebGL.
  constructor(canvas, runs) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.canvas = canvas;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.listeners = [];
    this.fill(runs);
    this.recolor();
    this.resize();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  fill(runs) {
    this.swimmers = runs.map((run, index) => new Swimmer(run, index === 0 ? "solid" : "faint"));
    const ghost = new Swimmer(runs[0], "ghost");
    ghost.place(0);
    this.colored = [...this.swimmers, ghost];
    this.tips = runs.flatMap(tips);
    this.box = new Box3().setFromPoints(this.tips);
    this.radius = 0.5 * this.box.getSize(new Vector3()).length();
    const obstacles = new Obstacles(runs[0], this.box, this.radius);
    this.tips.push(...obstacles.seen);
    this.colored.push(obstacles);
    this.centre = this.box.getCenter(new Vector3());
    this.grid_step = round_step(this.radius / 5);
    this.grid = new LineSegments(grid_lines(this.box, this.grid_step), new LineBasicMaterial());
    this.paths = runs.map((run) => new Line(lines(run.frames.position), new LineBasicMaterial({ depthTest: false })));
    for (const path of this.paths) path.renderOrder = 2;
    this.sky = new HemisphereLight();
    this.sky.position.set(0, 0, 1);
    this.sun = new DirectionalLight(0xffffff, 1.5);
    this.scene.add(this.sky, this.camera, this.grid, ...this.paths, ...this.colored.map((swimmer) => swimmer.group));
    this.sun.position.set(0.4, 0.8, 1);
    this.camera.add(this.sun);
    this.camera.near = this.radius / 50;
    this.camera.far = 40 * this.radius;
  }

  recolor() {
    for (const swimmer of this.colored) swimmer.recolor();
    this.grid.material.color.set(color("grid"));
    for (const path of this.paths) path.material.color.set(color("path"));
    this.sky.color.set(0xffffff);
    this.sky.groundColor.set(color("ground"));
    this.sky.intensity = 1.7;
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    const before = this.camera.aspect;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.view && before !== this.camera.aspect) this.look(this.view);
    else this.draw();
  }

  // Target and distance at which all tips fill the picture, seen along the direction.
  fit(direction) {
    const z = direction.clone().normalize(), x = new Vector3(0, 0, 1).cross(z).normalize(), y = z.clone().cross(x);
    const up = Math.tan(FIELD_OF_VIEW * Math.PI / 360), right = up * this.camera.aspect;
    // p is seen when |p·x − x₀| ≤ right (d − p·z) and likewise for y: each bound is linear in centre and distance
    const most = (value) => this.tips.reduce((best, p) => Math.max(best, value(p)), -Infinity);
    const bound = (axis, slope) => {
      const high = most((p) => p.dot(axis) + slope * p.dot(z)), low = most((p) => -p.dot(axis) + slope * p.dot(z));
      return { centre: 0.5 * (high - low), distance: 0.5 * (high + low) / slope };
    };
    const across = bound(x, right), along = bound(y, up), depth = this.centre.dot(z);
    const target = x.multiplyScalar(across.centre).addScaledVector(y, along.centre).addScaledVector(z, depth);
    return { target, distance: 1.08 * (Math.max(across.distance, along.distance) - depth) };
  }

  look(view) {
    this.view = view;
    const direction = new Vector3(...VIEWS[view]).normalize(), { target, distance } = this.fit(direction);
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(direction, distance);
    this.controls.update();
    this.draw();
  }

  orbit(right, up) {
    const arm = this.camera.position.clone().sub(this.controls.target);
    const tilt = Math.acos(arm.z / arm.length());
    const axis = new Vector3(0, 0, 1).cross(arm).normalize();
    arm.applyAxisAngle(axis, Math.min(Math.max(tilt - up, 0.01), Math.PI - 0.01) - tilt);
    arm.applyAxisAngle(new Vector3(0, 0, 1), right);
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  place(time) {
    for (const swimmer of this.swimmers) swimmer.place(time);
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
    for (const listener of this.listeners) listener(this.camera);
  }
}
