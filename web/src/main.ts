/** The page's beginning: libraries, buttons and keys. */

import "./style.css";

import { loadBytes, loadJson } from "./load";
import { element } from "./panel";
import { openMujoco } from "./physics";
import { Playground, say } from "./playground";
import { openRuntime } from "./policy";
import type { Index, Specification } from "./site";

/** Keys beside those that steer: code -> id of the button that they press. */
const SHORTCUTS: Record<string, string> = {
  Space: "pause", KeyL: "slow", KeyR: "reset", KeyP: "push", KeyC: "compare",
};

async function begin(): Promise<void> {
  say("Loading MuJoCo and the walk…");
  const [mujoco, runtime, index, specification] = await Promise.all([
    loadBytes("wasm/mujoco.wasm").then((wasm) => openMujoco(wasm.buffer)),
    loadBytes("wasm/onnxruntime.wasm"),
    loadJson<Index>("data/index.json"),
    loadJson<Specification>("data/specification.json"),
  ]);
  openRuntime(runtime.buffer);
  const playground = new Playground(mujoco, index, specification);
  bindButtons(playground);
  await playground.build();
  const draw = (now: number) => {
    requestAnimationFrame(draw); // first: one frame that fails is not the last one
    playground.frame(now);
  };
  requestAnimationFrame(draw);
  Object.assign(window, { playground }); // for the tests and the curious
}

function bindButtons(playground: Playground): void {
  const toggle = (id: string, flip: () => boolean) => {
    element(id).addEventListener("click", () => element(id).setAttribute("aria-pressed", String(flip())));
  };
  toggle("pause", () => (playground.paused = !playground.paused));
  toggle("slow", () => (playground.wishes.slow = !playground.wishes.slow));
  element("reset").addEventListener("click", () => playground.restart());
  element("push").addEventListener("click", () => playground.push());
  element("link").addEventListener("click", () => void copyLink(playground.address()));
  window.addEventListener("keydown", (event) => {
    const id = SHORTCUTS[event.code];
    if (!id || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    const onControl = event.target instanceof Element && event.target.closest("button, a, select, input:not([type=range])");
    if (event.code === "Space" && onControl) return; // it presses what has the focus, but no slider
    event.preventDefault();
    element(id).click();
  });
}

async function copyLink(link: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(link);
    say("The link is copied.");
  } catch {
    say("The link is in the address bar.");
  }
  setTimeout(() => say(""), 1800);
}

begin().catch((error: Error) => say(`The playground cannot start: ${error.message}`, true));
