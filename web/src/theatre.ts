/** What is on the stage now: a scene's characters, the policy that drives them, and their pictures. */

import type { Ground } from "./ground";
import type { Body } from "./physics";
import type { Policy } from "./policy";
import { Simulation } from "./simulation";
import { Figure } from "./view/figure";
import { Landscape } from "./view/landscape";
import { Orbit, type Angles } from "./view/orbit";
import { Signs } from "./view/signs";
import { dispose, isStacked, type Stage } from "./view/stage";
import type { Target } from "./input/pointer";
import { Walker } from "./walker";
import type { Wishes } from "./wishes";

interface Actor {
  walker: Walker;
  figure: Figure;
  signs: Signs;
  orbit: Orbit;
}

export class Theatre {
  readonly simulation: Simulation;
  private readonly actors: Actor[];
  private readonly landscape: Landscape;

  constructor(
    private readonly stage: Stage,
    private readonly body: Body,
    readonly ground: Ground,
    policy: Policy,
    private readonly wishes: Wishes,
    angles: Angles,
    onFailure: (error: Error) => void,
  ) {
    const count = wishes.compare ? 2 : 1;
    this.actors = Array.from({ length: count }, (_, i) => ({
      walker: new Walker(body, ground, wishes.base),
      figure: new Figure(body, i === 1),
      signs: new Signs(ground),
      orbit: new Orbit(angles),
    }));
    this.landscape = new Landscape(ground);
    stage.scene.add(this.landscape.group);
    for (const { figure, signs } of this.actors) stage.scene.add(figure.group, signs.group);
    const walkers = this.actors.map((actor) => actor.walker);
    this.simulation = new Simulation(walkers, policy, wishes, onFailure);
    for (const walker of ground.endless ? walkers : []) {
      walker.restart({ xy: [0, 0], heading: wishes.heading ?? this.startHeading });
    }
  }

  /** The adapted character, and the base if it is shown. */
  get walkers(): Walker[] {
    return this.simulation.walkers;
  }

  /** In the order of the pictures: the base comes first. */
  private get shown(): Actor[] {
    return [...this.actors].reverse();
  }

  /** Direction [rad] in which the adapted character's camera looks. */
  get forward(): number {
    return this.actors[0].orbit.direction;
  }

  /** Heading [rad] of the scene's start. */
  get startHeading(): number {
    return this.body.scene.starts[this.wishes.base].heading;
  }

  draw(seconds: number): void {
    this.stage.resize();
    const heading = this.wishes.heading ?? 0;
    for (const { walker, figure, signs, orbit } of this.actors) {
      walker.motion.refreshPositions();
      figure.place(walker.motion);
      signs.place(walker, heading, this.wishes.speed);
      const [x, y] = walker.rootXY;
      orbit.follow(figure.middle, this.ground.floorAt(x, y), heading, seconds);
    }
    this.stage.draw(
      this.shown.map(({ figure, signs, orbit }) => ({
        camera: orbit.camera,
        middle: orbit.middle,
        own: [figure.group, signs.group],
      })),
      (view) => this.landscape.follow(view.middle.x, view.middle.y),
    );
  }

  /** Where the characters can be touched. */
  targets(): Target[] {
    const { clientWidth, clientHeight } = this.stage.canvas;
    const [n, stacked] = [this.actors.length, isStacked(clientWidth, clientHeight)];
    return this.shown.map(({ figure, orbit }, i) => {
      const box = stacked ? { x: 0, y: i / n, w: 1, h: 1 / n } : { x: i / n, y: 0, w: 1 / n, h: 1 };
      return { camera: orbit.camera, middle: figure.middle, box };
    });
  }

  push(x: number, y: number): void {
    for (const walker of this.walkers) walker.push(x, y);
  }

  restart(): void {
    for (const walker of this.walkers) {
      walker.restart();
      walker.falls = 0;
    }
  }

  async close(): Promise<void> {
    dispose(this.landscape.group);
    for (const { figure, signs } of this.actors) {
      dispose(figure.group);
      dispose(signs.group);
    }
    await this.simulation.close();
    this.body.close();
  }
}
