/** One character with its goal: what adapt_envs.simulation.Worlds is to one world. */

import type { Ground } from "./ground";
import { type Goal, goalReward, writeObservation } from "./observation";
import { type Body, Motion } from "./physics";
import { headingOf, turnQuaternion, turnVector } from "./rotations";
import type { Start } from "./site";

/** Seconds that a character lies before it starts again. */
const LYING = 1.2;
/** Control steps over which speed and reward are averaged: one second. */
const AVERAGED = 30;

export class Walker {
  readonly motion: Motion;
  readonly history: Float32Array;
  readonly observation: Float32Array;
  readonly heightmap: Float32Array;
  goal: Goal = { target: [0, 0], speed: 1 };
  falls = 0;
  /** Control steps since the last start. */
  steps = 0;
  private lying = 0;
  private rewards: number[] = [];
  private path: [number, number][] = [];
  private pushed = 0;
  force: [number, number] = [0, 0];

  constructor(
    readonly body: Body,
    readonly ground: Ground,
    readonly base: string,
  ) {
    const { frames, links, link_size, size, heightmap } = body.specification;
    this.motion = new Motion(body);
    this.history = new Float32Array(frames * links.length * link_size);
    this.observation = new Float32Array(size);
    this.heightmap = new Float32Array(heightmap.size ** 2);
    this.restart();
  }

  private get frameSize(): number {
    return this.body.specification.links.length * this.body.specification.link_size;
  }

  private get now(): number {
    return this.history.length - this.frameSize;
  }

  get rootXY(): [number, number] {
    return [this.history[this.now], this.history[this.now + 1]];
  }

  get heading(): number {
    return headingOf(this.history, this.now + this.body.specification.link.orientation.offset);
  }

  /** Start as the scene says, on endless ground at the place and heading given. */
  restart(at?: { xy: [number, number]; heading: number }): void {
    const start = this.body.scene.starts[this.base];
    const { qpos, qvel, history } = at && this.ground.endless ? this.moved(start, at.xy, at.heading) : start;
    this.motion.restart(qpos, qvel);
    this.history.set(history);
    this.lying = 0;
    this.steps = 0;
    this.rewards = [];
    this.path = [];
    this.endPush();
  }

  /** A start state at another place of flat ground. */
  private moved(start: Start, [x, y]: [number, number], heading: number) {
    const { links, link_size: size, frames, link } = this.body.specification;
    const turn = heading - start.heading;
    const [qpos, qvel] = [Float64Array.from(start.qpos), Float64Array.from(start.qvel)];
    const history = Float32Array.from(start.history);
    turnQuaternion(qpos, 3, turn);
    turnVector(qpos, 0, turn);
    turnVector(qvel, 0, turn); // the root's angular velocity is in its own frame
    qpos[0] += x;
    qpos[1] += y;
    for (let at = 0; at < frames * links.length * size; at += size) {
      for (const part of [link.position, link.velocity, link.angular_velocity]) {
        turnVector(history, at + part.offset, turn);
      }
      turnQuaternion(history, at + link.orientation.offset, turn);
      history[at] += x;
      history[at + 1] += y;
    }
    return { qpos, qvel, history };
  }

  /** Hold the goal ahead in a world direction; see adapt_envs' `Goals.hold`. */
  aim(heading: number, speed: number): void {
    const { bases, task } = this.body.specification;
    const [x, y] = this.rootXY;
    const distance = speed * bases[this.base].held_seconds;
    const target: [number, number] = [x + distance * Math.cos(heading), y + distance * Math.sin(heading)];
    this.goal = { target: this.ground.inside(target, task.edge), speed };
  }

  /** Write what the policy sees. */
  look(): void {
    const [x, y] = this.rootXY;
    const { specification } = this.body;
    writeObservation(this.observation, this.history, this.ground.floorAt(x, y), this.goal, specification);
  }

  lookAround(): void {
    const [x, y] = this.rootXY;
    this.ground.writeHeightmap(this.heightmap, x, y, this.heading, this.body.specification.heightmap);
  }

  /** Push the torso with a force [N] for as long as the environments do. */
  push(x: number, y: number): void {
    const { push, control_hz, physics_steps } = this.body.specification;
    this.pushed = Math.round(push.seconds * control_hz) * physics_steps;
    this.force = [x, y];
    this.motion.push(x, y);
  }

  private endPush(): void {
    this.pushed = 0;
    this.force = [0, 0];
    this.motion.push(0, 0);
  }

  /** One physics step; a state that diverged starts again. */
  tick(): void {
    if (!this.motion.step()) {
      this.falls += 1;
      this.restart();
    }
    if (this.pushed > 0 && --this.pushed === 0) this.endPush();
  }

  /** End a control step: remember the links, count falls, and start again after lying for a while. */
  remember(): void {
    const { specification } = this.body;
    const before = this.rootXY;
    this.motion.refresh();
    this.history.copyWithin(0, this.frameSize);
    this.motion.writeLinks(this.history.subarray(this.now));
    this.steps += 1;
    this.measure(before);
    if (this.lying > 0 || this.fallen) {
      if (this.lying === 0) this.falls += 1;
      this.lying += 1 / specification.control_hz;
      if (this.lying > LYING) this.restart({ xy: this.rootXY, heading: this.headingToGoal() });
    }
  }

  /** As the environments count falls: on uneven ground a shin may brush a step. */
  get fallen(): boolean {
    const limit = this.ground.file.fall_height;
    return this.motion.touches((x, y, z) => limit === null || z - this.ground.floorAt(x, y) < limit);
  }

  /** Go on from another state of the present moment. */
  placeAt(qpos: ArrayLike<number>, qvel: ArrayLike<number>): void {
    this.motion.place(qpos, qvel);
    this.motion.writeLinks(this.history.subarray(this.now));
  }

  private headingToGoal(): number {
    const [x, y] = this.rootXY;
    return Math.atan2(this.goal.target[1] - y, this.goal.target[0] - x);
  }

  private measure(before: [number, number]): void {
    const after = this.rootXY;
    this.rewards.push(goalReward(before, after, this.goal, this.body.specification));
    this.path.push(after);
    if (this.rewards.length > AVERAGED) this.rewards.shift();
    if (this.path.length > AVERAGED + 1) this.path.shift();
  }

  get down(): boolean {
    return this.lying > 0;
  }

  /** Speed of the root over the last second [m/s]. */
  get speed(): number {
    if (this.path.length < 2) return 0;
    const [first, last] = [this.path[0], this.path[this.path.length - 1]];
    const seconds = (this.path.length - 1) / this.body.specification.control_hz;
    return Math.hypot(last[0] - first[0], last[1] - first[1]) / seconds;
  }

  /** Mean goal reward over the last second. */
  get reward(): number {
    return this.rewards.length ? this.rewards.reduce((sum, value) => sum + value, 0) / this.rewards.length : 0;
  }

  close(): void {
    this.motion.close();
  }
}
