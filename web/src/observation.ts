/** From the states of the links to what a policy sees, as the specification says. */

import type { Specification } from "./site";

export interface Goal {
  target: [number, number];
  speed: number;
}

/**
 * Write an observation into `out`.
 *
 * `history` holds `frames` states of all links in the world, oldest first; `floor` is the height of the ground under
 * the last root.
 */
export function writeObservation(
  out: Float32Array,
  history: Float32Array,
  floor: number,
  goal: Goal,
  specification: Specification,
): void {
  const { frames, links, link_size: size, link } = specification;
  const root = (frames - 1) * links.length * size;
  const heading = headingVector(history, root + link.orientation.offset);
  for (let at = 0; at < frames * links.length * size; at += size) {
    writeLink(out, history, at, root, floor, heading, link);
  }
  writeGoal(out, history[root], history[root + 1], heading, goal, specification);
}

interface Heading {
  c: number;
  s: number;
  half_c: number;
  half_s: number;
}

function headingVector(history: Float32Array, at: number): Heading {
  const [w, x, y, z] = history.subarray(at, at + 4);
  const [forward, left] = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z)];
  const norm = Math.max(Math.hypot(forward, left), 1e-9);
  const half = Math.atan2(left / norm, forward / norm) / 2;
  return { c: forward / norm, s: left / norm, half_c: Math.cos(half), half_s: Math.sin(half) };
}

function writeLink(
  out: Float32Array,
  history: Float32Array,
  at: number,
  root: number,
  floor: number,
  { c, s, half_c, half_s }: Heading,
  link: Specification["link"],
): void {
  const position = at + link.position.offset;
  const [x, y] = [history[position] - history[root], history[position + 1] - history[root + 1]];
  out[position] = c * x + s * y;
  out[position + 1] = c * y - s * x;
  out[position + 2] = history[position + 2] - floor;
  for (const { offset } of [link.velocity, link.angular_velocity]) {
    const [vx, vy] = [history[at + offset], history[at + offset + 1]];
    out[at + offset] = c * vx + s * vy;
    out[at + offset + 1] = c * vy - s * vx;
    out[at + offset + 2] = history[at + offset + 2];
  }
  const q = at + link.orientation.offset;
  const [qw, qx, qy, qz] = [history[q], history[q + 1], history[q + 2], history[q + 3]];
  const w = half_c * qw + half_s * qz;
  const sign = w < 0 ? -1 : 1;
  out[q] = sign * w;
  out[q + 1] = sign * (half_c * qx + half_s * qy);
  out[q + 2] = sign * (half_c * qy - half_s * qx);
  out[q + 3] = sign * (half_c * qz - half_s * qw);
}

function writeGoal(
  out: Float32Array,
  rootX: number,
  rootY: number,
  { c, s }: Heading,
  goal: Goal,
  specification: Specification,
): void {
  const [x, y] = [goal.target[0] - rootX, goal.target[1] - rootY];
  const distance = Math.hypot(x, y);
  const scale = distance < specification.task.no_direction ? 0 : 1 / distance;
  const at = specification.goal_offset;
  out[at + specification.goal.direction.offset] = (c * x + s * y) * scale;
  out[at + specification.goal.direction.offset + 1] = (c * y - s * x) * scale;
  out[at + specification.goal.distance.offset] = distance;
  out[at + specification.goal.speed.offset] = goal.speed;
}

/** Reward of a control step in [0, 1]: how well the preferred velocity was kept (paper, app. A). */
export function goalReward(
  before: [number, number],
  after: [number, number],
  goal: Goal,
  specification: Specification,
): number {
  const { goal_radius: radius, sharpness } = specification.task;
  const [x, y] = [goal.target[0] - before[0], goal.target[1] - before[1]];
  const scale = goal.speed / Math.max(Math.hypot(x, y), 1e-6);
  const rate = specification.control_hz;
  const miss = Math.hypot((after[0] - before[0]) * rate - x * scale, (after[1] - before[1]) * rate - y * scale);
  const left = Math.hypot(goal.target[0] - after[0], goal.target[1] - after[1]);
  return left < radius ? 1 : Math.exp((-sharpness * miss * miss) / goal.speed ** 2);
}
