/** What each picture shows, and the figures that matter: falls, speed, how well the goal is kept. */

import { element, spaced } from "./panel";
import type { Index } from "./site";
import type { Walker } from "./walker";
import type { Wishes } from "./wishes";

/** Below this share of the goal reward a figure is marked. */
const POOR = 0.35;
/** Control steps after a start before figures are judged: two seconds. */
const SETTLING = 60;
const FIGURES = ["falls", "speed", "goal kept"];
const UNITS = ["", " m/s", " %"];

/** Make a caption for each picture; the base's comes first. */
export function makeCaptions(count: number): void {
  element("captions").replaceChildren(...Array.from({ length: count }, caption));
}

function caption(): HTMLElement {
  const section = document.createElement("section");
  const list = document.createElement("dl");
  const rows = FIGURES.map((name) => {
    const row = document.createElement("div");
    row.append(make("dt", name), document.createElement("dd"));
    return row;
  });
  list.append(...rows);
  const box = Object.assign(document.createElement("div"), { className: "caption" });
  box.append(make("h2", ""), make("p", ""), list);
  section.append(box);
  return section;
}

/** Fill the captions; `walkers` are the adapted character and, if it is shown, the base. */
export function showCaptions(walkers: Walker[], wishes: Wishes, index: Index): void {
  const sections = [...element("captions").children].reverse();
  const blend = blendOf(wishes, index);
  const words = [[blend ? "Adapted" : "Base", blend || baseWords(wishes)], ["Base", baseWords(wishes)]];
  walkers.forEach((walker, i) => {
    const [title, text] = words[i];
    const section = sections[i];
    section.querySelector("h2")!.textContent = title;
    section.querySelector("p")!.textContent = text;
    const values = [String(walker.falls), walker.speed.toFixed(2), String(Math.round(100 * walker.reward))];
    const bad = [walker.down, false, walker.reward < POOR && walker.steps > SETTLING];
    section.querySelectorAll("dd").forEach((cell, j) => {
      cell.replaceChildren(values[j], make("small", UNITS[j]));
      cell.classList.toggle("bad", bad[j]);
    });
  });
}

function baseWords(wishes: Wishes): string {
  return `the ${wishes.base}, as it was trained`;
}

/** "Stoop 0.50 + Penguin 0.50", or nothing. */
function blendOf(wishes: Wishes, index: Index): string {
  const parts = index.bases[wishes.base].filter((part) => wishes.strengths[part.name]);
  return parts.map((part) => `${spaced(part.title)} ${wishes.strengths[part.name].toFixed(2)}`).join(" + ");
}

function make(kind: string, text: string): HTMLElement {
  return Object.assign(document.createElement(kind), { textContent: text });
}
