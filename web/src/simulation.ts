/** The clock: physics at 120 Hz, the policy at 30 Hz, for the base and the adapted character side by side. */

import type { Policy } from "./policy";
import type { Walker } from "./walker";

/** Longest time [s] that is made up for when the page was busy or hidden. */
const MOST_BEHIND = 0.25;

export interface Wish {
  heading: number | null;
  speed: number;
  strengths: Record<string, number>;
}

export class Simulation {
  /** Simulated time [s]. */
  time = 0;
  private behind = 0;
  private ticks = 0;
  private acting = false;
  private closed = false;
  /** Mean time of a control step's computing [ms]. */
  cost = 0;

  /** `walkers` are the adapted character and, if the two are compared, the base. */
  constructor(
    readonly walkers: Walker[],
    readonly policy: Policy,
    readonly wish: Wish,
    private readonly onFailure: (error: Error) => void,
  ) {}

  /** Advance by `seconds` of simulated time, as far as the policy's answers allow. */
  advance(seconds: number): void {
    this.behind = Math.min(this.behind + seconds, MOST_BEHIND);
    if (!this.acting && !this.closed) this.run().catch((error: Error) => this.fail(error));
  }

  private fail(error: Error): void {
    this.closed = true;
    this.onFailure(error);
  }

  private async run(): Promise<void> {
    this.acting = true;
    try {
      const { specification, scene } = this.walkers[0].body;
      const step = scene.exact.timestep;
      while (this.behind >= step && !this.closed) {
        const began = performance.now();
        if (this.ticks % specification.physics_steps === 0) await this.act();
        if (this.closed) return;
        for (const walker of this.walkers) walker.tick();
        this.ticks += 1;
        this.time += step;
        this.behind -= step;
        if (this.ticks % specification.physics_steps === 0) for (const walker of this.walkers) walker.remember();
        this.cost += 0.01 * (specification.physics_steps * (performance.now() - began) - this.cost);
      }
    } finally {
      this.acting = false;
    }
  }

  private async act(): Promise<void> {
    const { walkers, wish, policy } = this;
    const strengths = walkers.map((_, i) => (i === 0 ? wish.strengths : {}));
    const maps = policy.readsHeightmap(strengths);
    for (const walker of walkers) {
      walker.aim(wish.heading ?? 0, wish.speed);
      walker.look();
      if (maps) walker.lookAround();
    }
    const actions = await policy.act(
      joined(walkers.map((walker) => walker.observation)),
      maps ? joined(walkers.map((walker) => walker.heightmap)) : NOTHING,
      strengths,
    );
    if (this.closed) return;
    const size = actions.length / walkers.length;
    walkers.forEach((walker, i) => walker.motion.act(actions.subarray(i * size, (i + 1) * size)));
  }

  /** Stop for good, and free the characters. */
  async close(): Promise<void> {
    this.closed = true;
    while (this.acting) await new Promise((done) => setTimeout(done, 5));
    for (const walker of this.walkers) walker.close();
  }
}

const NOTHING = new Float32Array();

function joined(parts: Float32Array[]): Float32Array {
  const whole = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}
