/** The page's heart: loads what the wishes ask for, and runs it frame by frame. */

import { Ground } from "./ground";
import { bindPad } from "./input/pad";
import { Pointer } from "./input/pointer";
import { Steering } from "./input/steering";
import { makeCaptions, showCaptions } from "./figures";
import { loadBytes, loadJson } from "./load";
import { element, Panel } from "./panel";
import { Body, type Mujoco } from "./physics";
import { Policy } from "./policy";
import type { GroundFile, Index, Scene, Specification } from "./site";
import { Theatre } from "./theatre";
import type { Angles } from "./view/orbit";
import { Stage } from "./view/stage";
import { hashOf, SLOW, speedsOf, type Wishes, wishesOf } from "./wishes";

/** Longest frame [s] that is simulated at once. */
const LONGEST_FRAME = 0.25;
/** How the camera looks at first on each ground. */
const VIEWS: Record<string, Angles> = {
  flat: { azimuth: -0.85, elevation: 0.2, distance: 5.2 },
  blocks: { azimuth: -0.85, elevation: 0.72, distance: 7 },
};
/** Time [ms] between two updates of the figures. */
const UPDATES = 250;
/** Time [ms] between two updates of the address: browsers refuse more than some three in a second. */
const ADDRESSES = 1000;

export class Playground {
  wishes: Wishes;
  theatre: Theatre | null = null;
  paused = false;
  /** Frames drawn, and pushes given, so far. */
  frames = 0;
  pushes = 0;
  readonly stage = new Stage(element<HTMLCanvasElement>("stage"));
  private readonly angles: Angles = { ...VIEWS.flat };
  private readonly panel: Panel;
  private readonly steering: Steering;
  private readonly policies = new Map<string, Policy>();
  private building: Promise<void> = Promise.resolve();
  private wanted = 0;
  private last = performance.now();
  private updated = 0;
  private addressed = 0;

  constructor(
    readonly mujoco: Mujoco,
    readonly index: Index,
    readonly specification: Specification,
  ) {
    this.wishes = wishesOf(location.hash || "#walk-stoop=1&compare", index, specification);
    this.panel = new Panel(index, specification, () => this.wishes, {
      onTuned: () => void this.loadWeights().then((problem) => problem && say(problem, true)),
      onScene: () => void this.build(),
    });
    this.steering = new Steering((name) => element<HTMLButtonElement>(name).click());
    bindPad(element("pad"), element("knob"), (place) => (this.steering.pad = place));
    const targets = () => this.theatre?.targets() ?? [];
    new Pointer(this.stage.canvas, this.angles, targets, (x, y) => this.theatre?.push(x, y));
    window.addEventListener("hashchange", ({ newURL }) => {
      // Not of `location`: a frame in between may have written the wishes of before there again.
      this.wishes = wishesOf(new URL(newURL).hash, index, specification);
      void this.build();
    });
  }

  /** Load and show the scene that is wished for; the latest wish wins. */
  build(): Promise<void> {
    const number = ++this.wanted;
    this.panel.show();
    const failed = (error: Error) => {
      if (number === this.wanted) say(`This scene cannot be shown: ${error.message}`, true);
    };
    // What is kept never fails: the next wish is built whatever became of this one.
    this.building = this.building.then(() => this.buildNow(number)).catch(failed);
    return this.building;
  }

  private async buildNow(number: number): Promise<void> {
    if (number !== this.wanted) return;
    const { wishes, specification, policy } = this;
    say("Loading…");
    const [scene, ground, problem] = await Promise.all([
      loadJson<Scene>(`data/scenes/${wishes.body}-${wishes.lock}-${wishes.ground}.json`),
      loadGround(wishes.ground),
      this.loadWeights(),
    ]);
    if (number !== this.wanted) return; // another wish came meanwhile, and is built next
    if (!policy.ready) throw new Error(problem || `the weights of the ${wishes.base} are not there`);
    const before = this.theatre;
    this.theatre = null; // nothing is drawn of what is being closed
    await before?.close();
    const body = new Body(this.mujoco, scene, specification, ground.shares);
    wishes.heading ??= scene.starts[wishes.base].heading;
    if (ground !== before?.ground) Object.assign(this.angles, VIEWS[wishes.ground] ?? VIEWS.flat);
    const onFailure = (error: Error) => say(`The simulation stopped: ${error.message}`, true);
    this.theatre = new Theatre(this.stage, body, ground, policy, wishes, this.angles, onFailure);
    makeCaptions(this.theatre.walkers.length);
    this.panel.show();
    this.update();
    say(problem, problem !== "");
  }

  private get policy(): Policy {
    const { base } = this.wishes;
    if (!this.policies.has(base)) {
      const { size } = this.specification.heightmap;
      this.policies.set(base, new Policy(base, this.index.bases[base], loadBytes, size));
    }
    return this.policies.get(base)!;
  }

  /**
   * Load the weights of every adaptation that is to act and was not loaded yet.
   *
   * Returns what went wrong in words, or nothing; what cannot act then has no strength.
   */
  private async loadWeights(): Promise<string> {
    const { policy, wishes } = this;
    const names = Object.entries(wishes.strengths).flatMap(([name, strength]) => (strength ? [name] : []));
    const missing = names.filter((name) => !policy.has(name));
    if (missing.length) this.panel.showLoading(missing);
    let problem = "";
    try {
      await policy.add(names);
    } catch (error) {
      problem = `These weights cannot be loaded: ${(error as Error).message}`;
      if (this.wishes === wishes) for (const name of names) if (!policy.has(name)) delete wishes.strengths[name];
    }
    if (missing.length) this.panel.showLoading([]);
    return problem;
  }

  /** Push all characters from the side, as hard as the slider says. */
  push(): void {
    const [walker, { force }] = [this.theatre?.walkers[0], this.wishes];
    if (!walker) return;
    this.pushes += 1;
    const side = walker.heading + (Math.random() < 0.5 ? -1 : 1) * (Math.PI / 2);
    this.theatre!.push(force * Math.cos(side), force * Math.sin(side));
  }

  restart(): void {
    if (!this.theatre) return;
    this.wishes.heading = this.theatre.startHeading;
    this.theatre.restart();
    this.panel.show();
  }

  frame(now: number): void {
    const seconds = Math.min((now - this.last) / 1000, LONGEST_FRAME);
    this.last = now;
    const { theatre, wishes } = this;
    if (theatre) {
      this.steer(theatre.forward, seconds);
      if (!this.paused) theatre.simulation.advance(seconds * (wishes.slow ? SLOW : 1));
      theatre.draw(seconds);
      this.stage.ease(seconds);
      this.frames += 1;
    }
    if (now - this.updated > UPDATES) {
      this.updated = now;
      this.update();
    }
  }

  private steer(forward: number, seconds: number): void {
    const range = speedsOf(this.wishes.base, this.specification);
    const now = { heading: this.wishes.heading ?? 0, speed: this.wishes.speed };
    const wished = this.steering.steer(now, range, forward, seconds);
    if (wished === now) return;
    [this.wishes.heading, this.wishes.speed] = [wished.heading, wished.speed];
    this.panel.show();
  }

  private update(): void {
    if (!this.theatre) return;
    showCaptions(this.theatre.walkers, this.wishes, this.index);
    if (performance.now() - this.addressed > ADDRESSES) this.address();
  }

  /** The link to what is wished for now, which becomes the page's address. */
  address(): string {
    const hash = hashOf(this.wishes);
    if (hash !== location.hash) {
      this.addressed = performance.now();
      history.replaceState(null, "", hash);
    }
    return location.href;
  }
}

const grounds = new Map<string, Promise<Ground>>();

function loadGround(name: string): Promise<Ground> {
  if (!grounds.has(name)) {
    const loading = fetchGround(name);
    loading.catch(() => grounds.delete(name)); // it is tried again when it is asked for again
    grounds.set(name, loading);
  }
  return grounds.get(name)!;
}

async function fetchGround(name: string): Promise<Ground> {
  const file = await loadJson<GroundFile>(`data/grounds/${name}.json`);
  if (!file.surface) return new Ground(file, null);
  const bytes = await loadBytes(`data/grounds/${name}.bin`);
  return new Ground(file, new Float32Array(bytes.buffer));
}

/** Show a note over the picture; an empty one goes away. */
export function say(words: string, wrong = false): void {
  const note = element("note");
  note.textContent = words;
  note.classList.toggle("error", wrong);
}
