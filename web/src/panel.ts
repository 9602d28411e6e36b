/** The settings beside the picture: they write into the wishes, and show them. */

import type { Index, Listed, Specification } from "./site";
import { speedsOf, STRONGEST, WEAKEST, type Wishes } from "./wishes";

/** Scenes to try: words and the link's part that asks for them. */
const TRIES: [string, string][] = [
  ["Stoop", "#base=walk&walk-stoop=1&compare"],
  ["Goose step", "#base=walk&walk-goosestep=1"],
  ["Half strut, half joyful", "#base=walk&walk-strutting=0.5&walk-joyful=0.5"],
  ["On ice", "#base=walk&ground=ice&walk-icewalk=1&compare"],
  ["Over hills", "#base=walk&ground=hills&walk-terrainhills=1"],
  ["Among blocks", "#base=walk&ground=blocks&walk-obstacles=1"],
  ["Long shins", "#base=run&body=long_shins&run-longshins=1&compare"],
  ["Stiff knee", "#base=run&lock=right_knee&run-lockedrightknee=1&compare"],
];

export interface Listener {
  /** A strength, the speed, the heading or the force changed. */
  onTuned(name: string): void;
  /** Base, body, lock, ground or the comparison changed: another scene. */
  onScene(): void;
}

export class Panel {
  private readonly sliders = new Map<string, { row: HTMLElement; input: HTMLInputElement; output: HTMLElement }>();

  constructor(
    private readonly index: Index,
    private readonly specification: Specification,
    private readonly wishes: () => Wishes,
    private readonly listener: Listener,
  ) {
    const links = TRIES.map(([words, href]) => Object.assign(document.createElement("a"), { textContent: words, href }));
    element("tries").replaceChildren(...links);
    for (const base of Object.keys(index.bases)) element("bases").append(this.baseButton(base));
    this.bindSelect("body", index.bodies);
    this.bindSelect("lock", index.locks);
    this.bindSelect("ground", index.grounds);
    this.bindRange("speed", (value) => (this.wishes().speed = value));
    this.bindRange("heading", (value) => (this.wishes().heading = (value * Math.PI) / 180));
    this.bindRange("force", (value) => (this.wishes().force = value));
    const compare = element<HTMLInputElement>("compare");
    compare.addEventListener("change", () => {
      this.wishes().compare = compare.checked;
      listener.onScene();
    });
  }

  private baseButton(base: string): HTMLLabelElement {
    const label = document.createElement("label");
    const input = Object.assign(document.createElement("input"), { type: "radio", name: "base", value: base });
    label.append(input, base);
    input.addEventListener("change", () => {
      const wishes = this.wishes();
      [wishes.base, wishes.strengths] = [base, {}];
      const [low, high] = this.specification.bases[base].speeds;
      wishes.speed = (low + high) / 2;
      this.listener.onScene();
    });
    return label;
  }

  private bindSelect(name: "body" | "lock" | "ground", table: Record<string, string>): void {
    const select = element<HTMLSelectElement>(name);
    const options = Object.entries(table).map(([value, words]) => new Option(titled(words), value));
    select.replaceChildren(...options);
    select.addEventListener("change", () => {
      this.wishes()[name] = select.value;
      if (name === "ground") this.wishes().heading = null;
      this.listener.onScene();
    });
  }

  private bindRange(name: string, set: (value: number) => void): void {
    const input = element<HTMLInputElement>(name);
    input.addEventListener("input", () => {
      set(Number(input.value));
      this.listener.onTuned(name);
      this.show();
    });
  }

  /** Make the sliders of a base's adaptations. */
  private listAdaptations(base: string): void {
    const list = element("adaptations");
    if (list.dataset.base === base) return;
    list.dataset.base = base;
    this.sliders.clear();
    const scale = document.createElement("div");
    scale.className = "scale";
    scale.ariaHidden = "true";
    scale.append(...[WEAKEST, 0, 0.5, 1, STRONGEST].map((tick) => span(String(tick).replace("-", "−"))));
    list.replaceChildren(list.querySelector("legend")!, scale, ...this.index.bases[base].map((part) => this.slider(part)));
  }

  private slider(part: Listed): HTMLElement {
    const row = Object.assign(document.createElement("label"), { className: "row", title: `${part.words}.` });
    const range = { type: "range", min: String(WEAKEST), max: String(STRONGEST), step: "0.05", id: part.name };
    const input = Object.assign(document.createElement("input"), range);
    const output = document.createElement("output");
    row.append(span(spaced(part.title)), input, output);
    const set = (value: number) => {
      this.wishes().strengths[part.name] = value;
      this.listener.onTuned(part.name);
      this.show();
    };
    input.addEventListener("input", () => set(Number(input.value)));
    input.addEventListener("dblclick", () => set(0));
    this.sliders.set(part.name, { row, input, output });
    return row;
  }

  /** Show the wishes. */
  show(): void {
    const wishes = this.wishes();
    this.listAdaptations(wishes.base);
    for (const [name, { row, input, output }] of this.sliders) {
      const strength = wishes.strengths[name] ?? 0;
      fill(input, strength, 0);
      output.textContent = row.classList.contains("loading") ? "…" : strength.toFixed(2).replace("-", "−");
      row.classList.toggle("acts", strength !== 0);
    }
    const speed = element<HTMLInputElement>("speed");
    [speed.min, speed.max] = speedsOf(wishes.base, this.specification).map(String) as [string, string];
    fill(speed, wishes.speed, Number(speed.min));
    const degrees = Math.round(((wishes.heading ?? 0) * 180) / Math.PI);
    fill(element<HTMLInputElement>("heading"), degrees, 0);
    fill(element<HTMLInputElement>("force"), wishes.force, 50);
    element("speed-value").textContent = `${wishes.speed.toFixed(2)} m/s`;
    element("heading-value").textContent = `${degrees}°`.replace("-", "−");
    element("force-value").textContent = `${Math.round(wishes.force)} N`;
    for (const name of ["body", "lock", "ground"] as const) element<HTMLSelectElement>(name).value = wishes[name];
    element<HTMLInputElement>("compare").checked = wishes.compare;
    element("slow").setAttribute("aria-pressed", String(wishes.slow));
    for (const radio of document.querySelectorAll<HTMLInputElement>("#bases input")) {
      radio.checked = radio.value === wishes.base;
    }
  }

  /** Mark adaptations whose weights are under way. */
  showLoading(names: string[]): void {
    for (const [name, { row }] of this.sliders) row.classList.toggle("loading", names.includes(name));
    this.show();
  }
}

/** Give a slider a value, and its track a line from `zero` to it. */
function fill(input: HTMLInputElement, value: number, zero: number): void {
  input.value = String(value);
  const [low, high] = [Number(input.min), Number(input.max)];
  const share = (at: number) => `${(100 * (at - low)) / (high - low)}%`;
  input.style.setProperty("--from", share(Math.min(value, zero)));
  input.style.setProperty("--to", share(Math.max(value, zero)));
}

export function element<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

function span(text: string): HTMLSpanElement {
  return Object.assign(document.createElement("span"), { textContent: text });
}

/** "LockedRightKnee" as "Locked right knee". */
export function spaced(name: string): string {
  const words = name.replace(/([a-z])([A-Z])/g, "$1 $2").toLowerCase();
  return titled(words);
}

function titled(words: string): string {
  return words.charAt(0).toUpperCase() + words.slice(1);
}
