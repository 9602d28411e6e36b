/** MuJoCo in the browser: models from the site's files, and the state of one character. */

import loadMujoco, { type MainModule, type MjData, type MjModel } from "@mujoco/mujoco";

import type { Scene, Specification } from "./site";

export type Mujoco = MainModule;

export function openMujoco(wasm: ArrayBuffer): Promise<Mujoco> {
  return loadMujoco({ wasmBinary: wasm }) as Promise<Mujoco>;
}

/** A compiled character on its ground; `close` frees it. */
export class Body {
  readonly model: MjModel;
  readonly actuators: number[];
  readonly torso: number;
  readonly fallParts: { sensor: number; links: number[] }[];
  readonly firstLink: number;

  constructor(
    readonly mujoco: Mujoco,
    readonly scene: Scene,
    readonly specification: Specification,
    shares: Float32Array | null,
  ) {
    this.model = mujoco.MjModel.from_xml_string(scene.mjcf);
    const { timestep, ...fields } = scene.exact;
    this.model.opt.timestep = timestep;
    const model = this.model as unknown as Record<string, Float32Array | Float64Array>;
    for (const [name, values] of Object.entries(fields)) model[name].set(values);
    if (shares) model.hfield_data.set(shares);
    this.actuators = scene.joints.map((joint) => specification.joints.indexOf(joint));
    this.torso = this.id("mjOBJ_BODY", specification.push.link);
    this.firstLink = this.id("mjOBJ_BODY", specification.links[0]);
    this.fallParts = Object.entries(specification.fall_sensors).map(([name, links]) => ({
      sensor: this.model.sensor_adr[this.id("mjOBJ_SENSOR", name)],
      links: links.map((link) => this.id("mjOBJ_BODY", link)),
    }));
  }

  private id(kind: "mjOBJ_BODY" | "mjOBJ_SENSOR", name: string): number {
    return this.mujoco.mj_name2id(this.model, this.mujoco.mjtObj[kind].value, name);
  }

  close(): void {
    this.model.delete();
  }
}

/** The state of one character in motion; `close` frees it. */
export class Motion {
  readonly data: MjData;

  constructor(readonly body: Body) {
    this.data = new body.mujoco.MjData(body.model);
  }

  restart(qpos: ArrayLike<number>, qvel: ArrayLike<number>): void {
    this.body.mujoco.mj_resetData(this.body.model, this.data);
    this.place(qpos, qvel);
  }

  /** Put the character somewhere and go on from there. */
  place(qpos: ArrayLike<number>, qvel: ArrayLike<number>): void {
    this.data.qpos.set(qpos);
    this.data.qvel.set(qvel);
    this.refresh();
  }

  /** Take an action: one number in [-1, 1] for each of the specification's joints. */
  act(action: ArrayLike<number>): void {
    const ctrl = this.data.ctrl as Float64Array;
    this.body.actuators.forEach((joint, i) => (ctrl[i] = Math.min(Math.max(action[joint], -1), 1)));
  }

  /** Push the torso with a force [N] along the ground until it is set again. */
  push(x: number, y: number): void {
    const at = 6 * this.body.torso;
    const forces = this.data.xfrc_applied as Float64Array;
    [forces[at], forces[at + 1]] = [x, y];
  }

  /** Advance by one step of 1/120 s; false if the physics broke down. */
  step(): boolean {
    const before = this.data.time;
    this.body.mujoco.mj_step(this.body.model, this.data);
    return this.data.time > before; // MuJoCo restarts the clock of a state that diverged
  }

  /** Bring positions, velocities and sensors up to the state after the last step. */
  refresh(): void {
    const { mujoco, model } = this.body;
    mujoco.mj_fwdPosition(model, this.data);
    mujoco.mj_sensorPos(model, this.data);
    mujoco.mj_fwdVelocity(model, this.data);
    mujoco.mj_sensorVel(model, this.data);
  }

  /** Bring positions alone up to date, for pictures. */
  refreshPositions(): void {
    this.body.mujoco.mj_kinematics(this.body.model, this.data);
  }

  /** Whether it touches what stands still with a part that must not, one of whose links is `low`. */
  touches(low: (x: number, y: number, z: number) => boolean): boolean {
    const sensors = this.data.sensordata as Float64Array;
    const xpos = this.data.xpos as Float64Array;
    const isLow = (link: number) => low(xpos[3 * link], xpos[3 * link + 1], xpos[3 * link + 2]);
    return this.body.fallParts.some(({ sensor, links }) => sensors[sensor] > 0 && links.some(isLow));
  }

  /** Write the states of the links in the world into `out`, as the specification lays them out. */
  writeLinks(out: Float32Array): void {
    const { links, link_size: size, link } = this.body.specification;
    const { xpos, xquat, cvel, subtree_com: com } = this.data;
    const first = this.body.firstLink;
    for (let i = 0; i < links.length; i++) {
      const [at, p, q, v] = [i * size, 3 * (first + i), 4 * (first + i), 6 * (first + i)];
      const offset = [0, 1, 2].map((k) => xpos[p + k] - com[3 * first + k]);
      for (let k = 0; k < 3; k++) {
        const [next, last] = [(k + 1) % 3, (k + 2) % 3];
        out[at + link.position.offset + k] = xpos[p + k];
        // MuJoCo's velocity is that at the centre of mass; the link's origin adds omega x offset.
        const carried = cvel[v + next] * offset[last] - cvel[v + last] * offset[next];
        out[at + link.velocity.offset + k] = cvel[v + 3 + k] + carried;
        out[at + link.angular_velocity.offset + k] = cvel[v + k];
      }
      for (let k = 0; k < 4; k++) out[at + link.orientation.offset + k] = xquat[q + k];
    }
  }

  close(): void {
    this.data.delete();
  }
}
