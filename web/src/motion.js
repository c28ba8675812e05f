// Where each body is at a time: rotations interpolated between the stored frames, positions by the tree of joints.
import { Quaternion, Vector3 } from "three";

export class Motion {
  constructor(run) {
    this.bodies = run.bodies;
    this.joints = run.joints;
    this.order = run.joint_order;
    this.time = run.frames.time;
    this.position = run.frames.position;
    this.rotation = run.frames.rotation;
    this.centres = run.bodies.map(() => new Vector3());
    this.turns = run.bodies.map(() => new Quaternion());
    this.joint_points = run.joints.map(() => new Vector3());
    this.arm = new Vector3();
  }

  // The last frame that does not lie after the time, and the fraction of the way to the next one.
  frame_at(time) {
    let low = 0, high = this.time.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.time[middle] <= time) low = middle;
      else high = middle;
    }
    if (high === low) return [low, 0];
    const part = (time - this.time[low]) / (this.time[high] - this.time[low]);
    return [low, Math.min(Math.max(part, 0), 1)];
  }

  // Fills centres [bodies], turns [bodies] and joint_points [joints].
  pose(time) {
    const [frame, part] = this.frame_at(time);
    const next = Math.min(frame + 1, this.time.length - 1);
    const count = this.bodies.length, x = this.position, q = this.rotation, other = new Quaternion();
    for (let i = 0; i < count; ++i) {
      this.turns[i].fromArray(q, 4 * (frame * count + i)).slerp(other.fromArray(q, 4 * (next * count + i)), part);
    }
    this.centres[0].fromArray(x, 3 * frame).lerp(this.arm.fromArray(x, 3 * next), part);
    for (const j of this.order) {
      const joint = this.joints[j];
      const point = this.joint_points[j].fromArray(joint.parent_offset)
        .applyQuaternion(this.turns[joint.parent]).add(this.centres[joint.parent]);
      this.arm.fromArray(joint.child_offset).applyQuaternion(this.turns[joint.child]);
      this.centres[joint.child].copy(point).sub(this.arm);
    }
    return this;
  }
}
