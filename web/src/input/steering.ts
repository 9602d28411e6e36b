/** Keys, gamepad and the touch pad: they turn the heading and change the preferred speed. */

import { wrapped } from "../rotations";
import { clipped } from "../wishes";

/** While a key is held: turn [rad/s] and change of speed [m/s each second]. */
const [TURN, FASTER] = [1.5, 0.7];
const DEAD_ZONE = 0.18;
const KEYS: Record<string, [number, number]> = {
  KeyW: [0, 1], ArrowUp: [0, 1], KeyS: [0, -1], ArrowDown: [0, -1],
  KeyA: [1, 0], ArrowLeft: [1, 0], KeyD: [-1, 0], ArrowRight: [-1, 0],
};
/** Buttons of a standard gamepad. */
const PAD_BUTTONS: Record<number, string> = { 0: "push", 1: "reset", 3: "compare", 9: "pause" };

export interface Steered {
  heading: number;
  speed: number;
}

export class Steering {
  private readonly held = new Set<string>();
  private readonly pressed = new Set<number>();
  /** Where the touch pad's knob is: right and up, each in [-1, 1]; null while nobody touches it. */
  pad: [number, number] | null = null;

  constructor(private readonly onButton: (name: string) => void) {
    window.addEventListener("keydown", (event) => this.press(event));
    window.addEventListener("keyup", (event) => this.held.delete(event.code));
    window.addEventListener("blur", () => this.held.clear());
  }

  private press(event: KeyboardEvent): void {
    if (!(event.code in KEYS) || event.ctrlKey || event.metaKey || event.altKey) return;
    const arrows = event.code.startsWith("Arrow");
    const on = (kinds: string) => event.target instanceof Element && event.target.closest(kinds) !== null;
    if (arrows && on("input, select")) return;
    // Arrows must not scroll the page, nor letters choose from a list that still has the focus.
    if (arrows || on("select")) event.preventDefault();
    this.held.add(event.code);
  }

  /** The wish after `seconds` of what is held now; `forward` is the direction that the camera looks in. */
  steer(now: Steered, range: [number, number], forward: number, seconds: number): Steered {
    let [turn, faster] = [0, 0];
    for (const key of this.held) {
      turn += KEYS[key][0];
      faster += KEYS[key][1];
    }
    const stick = this.pad ?? this.gamepad();
    if (stick) return towards(stick, now, range, forward);
    if (turn === 0 && faster === 0) return now;
    return {
      heading: wrapped(now.heading + Math.sign(turn) * TURN * seconds),
      speed: clipped(now.speed + Math.sign(faster) * FASTER * seconds, range),
    };
  }

  private gamepad(): [number, number] | null {
    const pad = navigator.getGamepads?.().find((found) => found?.connected);
    if (!pad) return null;
    for (const [button, name] of Object.entries(PAD_BUTTONS)) {
      const down = pad.buttons[Number(button)]?.pressed ?? false;
      if (down && !this.pressed.has(Number(button))) this.onButton(name);
      if (down) this.pressed.add(Number(button));
      else this.pressed.delete(Number(button));
    }
    const stick: [number, number] = [pad.axes[0] ?? 0, -(pad.axes[1] ?? 0)];
    return Math.hypot(...stick) < DEAD_ZONE ? null : stick; // at rest it leaves the steering to the keys
  }
}

/** A stick gives the direction as seen by the camera, and the speed by how far it is pushed. */
export function towards(
  [right, up]: [number, number],
  now: Steered,
  [low, high]: [number, number],
  forward: number,
): Steered {
  const reach = Math.min(Math.hypot(right, up), 1);
  if (reach < DEAD_ZONE) return now;
  const share = (reach - DEAD_ZONE) / (1 - DEAD_ZONE);
  return { heading: wrapped(forward + Math.atan2(-right, up)), speed: low + share * (high - low) };
}
