/** The built page in a real browser: what a person does with keys, mouse and fingers. */

import { afterAll, afterEach, beforeAll, describe, expect, test } from "vitest";

import type { Playground } from "../src/playground";
import { CHROMIUM, COARSE, DESKTOP, openSite, PHONE, PICTURES, type Site, type Visit, visit } from "./browser";

declare const playground: Playground;

const LARGEST_FIRST_VISIT = 25e6;
/** Drawing in software on a busy machine takes its time. */
const PATIENCE = { timeout: 240_000 };
/** How long memory is watched [ms]. */
const WATCHED = Number(process.env.WATCHED ?? 120_000);
let site: Site;

if (!CHROMIUM) console.log("skipped: no Chromium here; say where one is with CHROMIUM=/path/to/chromium");

describe.skipIf(!CHROMIUM)("the page", () => {
  beforeAll(async () => {
    site = await openSite();
  });
  afterEach(() => site.closePages());
  afterAll(() => site?.close());

  /** Let so many seconds be simulated, as fast as this machine can, however slowly it draws. */
  async function simulated({ page }: Visit, seconds: number): Promise<void> {
    await page.evaluate(async (seconds: number) => {
      const { simulation } = playground.theatre!;
      const end = simulation.time + seconds;
      while (simulation.time < end) {
        simulation.advance(0.1);
        await new Promise((done) => setTimeout(done, 5));
      }
    }, seconds);
  }

  /** Hold a key until the wishes say so. */
  async function held({ page }: Visit, key: "KeyW" | "KeyA", until: string): Promise<void> {
    await page.keyboard.down(key);
    await page.waitForFunction(until, PATIENCE);
    await page.keyboard.up(key);
  }

  /** What the adapted character does now. */
  function state({ page }: Visit) {
    return page.evaluate(() => {
      const walker = playground.theatre!.walkers[0];
      const { falls, rootXY, speed, heading } = walker;
      return { falls, x: rootXY[0], y: rootXY[1], speed, heading, height: walker.motion.data.qpos[2] as number };
    });
  }

  /** How far the trunk is bent forward [rad], over two seconds. */
  async function bent(visited: Visit): Promise<number> {
    let sum = 0;
    for (let i = 0; i < 20; i++) {
      await simulated(visited, 0.1);
      sum += await visited.page.evaluate(() => {
        const walker = playground.theatre!.walkers[0];
        const at = 9 * walker.body.torso; // the trunk's z axis in the world is the matrix's last column
        const m = walker.motion.data.xmat as Float64Array;
        return Math.atan2(Math.hypot(m[at + 2], m[at + 5]), m[at + 8]);
      });
    }
    return sum / 20;
  }

  /** Say how fast the page draws and simulates by itself: figures of this machine, which nothing is asked of. */
  async function reportFrames({ page }: Visit, name: string): Promise<void> {
    const { frames, seconds, cost } = await page.evaluate(async () => {
      const [first, start] = [playground.frames, performance.now()];
      const cost = () => playground.theatre!.simulation.cost;
      const time = () => (performance.now() - start) / 1000;
      const passed = () => ({ frames: playground.frames - first, seconds: time(), cost: cost() });
      while (passed().seconds < 4 || (passed().frames < 4 && passed().seconds < 20)) {
        await new Promise((done) => setTimeout(done, 100));
      }
      return passed();
    });
    const rate = (frames / seconds).toFixed(1);
    console.log(`${name}: ${rate} frames a second, drawn by the processor (${frames} in ${seconds.toFixed(1)} s)`);
    console.log(`${name}: both characters' control step takes ${cost.toFixed(1)} ms of the 33 between two`);
  }

  /** Colours in a picture of the canvas, and the share of its pixels that are a character's red or blue. */
  async function colours({ page }: Visit, name: string) {
    const canvas = (await page.$("#stage"))!;
    await canvas.screenshot({ path: `${PICTURES}${name}-canvas.png` as `${string}.png` });
    const picture = await page.screenshot({ encoding: "base64", path: `${PICTURES}${name}.png` as `${string}.png` });
    return page.evaluate(async (base64: string) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
      const pen = new OffscreenCanvas(image.width, image.height).getContext("2d")!;
      pen.drawImage(image, 0, 0);
      const { data } = pen.getImageData(0, 0, image.width, image.height);
      const found = new Set<number>();
      let painted = 0;
      for (let i = 0; i < data.length; i += 4) {
        found.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
        if (Math.abs(data[i] - data[i + 2]) > 60) painted += 1;
      }
      return { count: found.size, painted: (4 * painted) / data.length };
    }, picture as string);
  }

  function clean(visited: Visit): void {
    expect(visited.complaints).toEqual([]);
    expect(visited.elsewhere).toEqual([]);
  }

  test("opens with little, and shows two characters", async () => {
    const visited = await visit(site, "", DESKTOP);
    await simulated(visited, 1);
    const { count, painted } = await colours(visited, "desktop");
    expect(visited.bytes()).toBeLessThan(LARGEST_FIRST_VISIT);
    expect(count).toBeGreaterThan(2000);
    expect(painted).toBeGreaterThan(0.01);
    expect(await visited.page.$$eval(".caption", (found) => found.length)).toBe(2);
    clean(visited);
    console.log(`first visit: ${(visited.bytes() / 1e6).toFixed(1)} MB`);
    await reportFrames(visited, "desktop, 1280 x 800");
  });

  test("W held for five seconds: it moved, goes faster and stands", async () => {
    const visited = await visit(site, "#speed=1");
    await simulated(visited, 0.5);
    const before = await state(visited);
    await visited.page.keyboard.down("KeyW");
    await simulated(visited, 5);
    await held(visited, "KeyW", "playground.wishes.speed > 1.4");
    await simulated(visited, 2);
    const after = await state(visited);
    expect(after.x - before.x).toBeGreaterThan(4);
    expect(after.falls).toBe(0);
    expect(after.height).toBeGreaterThan(0.7);
    expect(after.speed).toBeGreaterThan(1.2);
    clean(visited);
  });

  test("A turns it to the left", async () => {
    const visited = await visit(site, "");
    await held(visited, "KeyA", "playground.wishes.heading > 1");
    await simulated(visited, 4);
    const { heading, falls } = await state(visited);
    expect(heading).toBeGreaterThan(0.6);
    expect(falls).toBe(0);
  });

  test("the slider of Stoop from 0 to 1, by keyboard, bends the trunk", async () => {
    const visited = await visit(site, "#speed=0.95");
    await simulated(visited, 1);
    const upright = await bent(visited);
    await visited.page.focus("#walk-stoop");
    for (let i = 0; i < 20; i++) await visited.page.keyboard.press("ArrowRight");
    await visited.page.waitForFunction("playground.policies.get('walk').has('walk-stoop')", PATIENCE);
    expect(await visited.page.evaluate(() => playground.wishes.strengths["walk-stoop"])).toBeCloseTo(1);
    await simulated(visited, 2);
    const stooped = await bent(visited);
    console.log(`trunk: ${upright.toFixed(2)} rad at strength 0, ${stooped.toFixed(2)} rad at 1`);
    expect(stooped - upright).toBeGreaterThan(0.2);
    expect((await state(visited)).falls).toBe(0);
    clean(visited);
  });

  test("a push with the button, and it goes on", async () => {
    const visited = await visit(site, "#walk-pushwalk=1&force=150");
    await simulated(visited, 2);
    await visited.page.click("#pause"); // so that it can be seen before its fifth of a second is over
    await visited.page.click("#push");
    const force = await visited.page.evaluate(() => Math.hypot(...playground.theatre!.walkers[0].force));
    expect(force).toBeCloseTo(150);
    await visited.page.click("#pause");
    const before = await state(visited);
    await simulated(visited, 4);
    const after = await state(visited);
    expect(await visited.page.evaluate(() => Math.hypot(...playground.theatre!.walkers[0].force))).toBe(0);
    expect(after.falls).toBe(0);
    expect(after.height).toBeGreaterThan(0.7);
    expect(Math.hypot(after.x - before.x, after.y - before.y)).toBeGreaterThan(2.5);
    clean(visited);
  });

  test("pulling the character with the mouse pushes it that way", async () => {
    const visited = await visit(site, "#base=walk");
    await visited.page.click("#pause");
    const place = await visited.page.evaluate(() => {
      const { camera, middle } = playground.theatre!.targets()[0];
      const seen = middle.clone().project(camera);
      const box = document.getElementById("stage")!.getBoundingClientRect();
      return { x: box.left + ((seen.x + 1) / 2) * box.width, y: box.top + ((1 - seen.y) / 2) * box.height };
    });
    await visited.page.mouse.move(place.x, place.y);
    await visited.page.mouse.down();
    await visited.page.mouse.move(place.x + 160, place.y, { steps: 4 });
    await visited.page.mouse.up();
    const force = await visited.page.evaluate(() => playground.theatre!.walkers[0].force);
    expect(Math.hypot(...force)).toBeGreaterThan(50);
  });

  test("a tap on the character does not push it", async () => {
    const visited = await visit(site, "#base=walk");
    await visited.page.click("#pause");
    const box = await visited.page.evaluate(() => {
      const { camera, middle } = playground.theatre!.targets()[0];
      const seen = middle.clone().setZ(middle.z + 0.4).project(camera);
      const box = document.getElementById("stage")!.getBoundingClientRect();
      return { x: box.left + ((seen.x + 1) / 2) * box.width, y: box.top + ((1 - seen.y) / 2) * box.height };
    });
    await visited.page.mouse.click(box.x, box.y);
    expect(await visited.page.evaluate(() => playground.theatre!.walkers[0].force)).toEqual([0, 0]);
  });

  test("a scene that cannot be fetched is not the last one", async () => {
    const visited = await visit(site, "#base=walk");
    await visited.page.setOfflineMode(true);
    await visited.page.select("#ground", "hills");
    await visited.page.waitForFunction("document.getElementById('note').classList.contains('error')", PATIENCE);
    await visited.page.setOfflineMode(false);
    await visited.page.select("#ground", "ice");
    await visited.page.waitForFunction("playground.theatre?.ground.file.friction < 0.2", PATIENCE);
    await visited.page.select("#ground", "hills");
    await visited.page.waitForFunction("playground.theatre && !playground.theatre.ground.endless", PATIENCE);
    expect(await visited.page.evaluate(() => document.getElementById("note")!.textContent)).toBe("");
  });

  test("who changes their mind while a scene loads gets the last one", async () => {
    const visited = await visit(site, "#base=walk");
    await visited.page.evaluate(() => {
      const choose = (base: string) => document.querySelector<HTMLInputElement>(`#bases [value=${base}]`)!.click();
      for (const base of ["run", "walk", "run"]) choose(base);
    });
    await visited.page.waitForFunction("playground.theatre?.walkers[0].base === 'run'", PATIENCE);
    await simulated(visited, 1);
    expect((await state(visited)).falls).toBe(0);
    clean(visited);
  });

  test("body, lock, ground and base can be chosen, and the link restores them", async () => {
    const visited = await visit(site, "#base=walk"); // without a hash the base is shown already
    await visited.page.evaluate(() => document.querySelector<HTMLInputElement>("#bases [value=run]")!.click());
    await visited.page.select("#body", "long_shins");
    await visited.page.select("#lock", "right_knee");
    await visited.page.select("#ground", "ice");
    await visited.page.click("#compare");
    await visited.page.waitForFunction("playground.theatre?.ground.file.friction < 0.2 && playground.theatre.walkers.length == 2", PATIENCE);
    await visited.page.waitForFunction("location.hash.includes('ice') && location.hash.includes('compare')", PATIENCE);
    const hash = await visited.page.evaluate(() => location.hash);
    const again = await visit(site, hash);
    const wishes = await again.page.evaluate(() => playground.wishes);
    expect(wishes).toMatchObject({ base: "run", body: "long_shins", lock: "right_knee", ground: "ice", compare: true });
    expect(await again.page.evaluate(() => playground.theatre!.walkers[0].body.model.nu)).toBe(27);
    clean(visited);
    clean(again);
  });

  test("a link that is copied at once says what was just chosen", async () => {
    const visited = await visit(site, "#base=walk");
    const copied = await visited.page.evaluate(() => {
      return new Promise<string>((done) => {
        navigator.clipboard.writeText = async (text) => done(text);
        for (const id of ["compare", "slow", "link"]) document.getElementById(id)!.click();
      });
    });
    expect(copied).toMatch(/#base=walk&.*&compare&slow$/);
  });

  test.each([
    ["hills", "#ground=hills&walk-terrainhills=1"],
    ["blocks", "#ground=blocks&walk-obstacles=1"],
    ["ice", "#ground=ice&walk-icewalk=1&compare"],
    ["longshins", "#base=run&body=long_shins&run-longshins=1&compare"],
    ["blend", "#walk-strutting=0.5&walk-joyful=0.5"],
  ])("%s: the adapted character walks there", async (name, hash) => {
    const visited = await visit(site, hash, DESKTOP);
    const before = await state(visited);
    await simulated(visited, 3);
    const after = await state(visited);
    const { count, painted } = await colours(visited, name);
    expect(after.falls).toBe(0);
    expect(Math.hypot(after.x - before.x, after.y - before.y)).toBeGreaterThan(1);
    expect(count).toBeGreaterThan(2000);
    expect(painted).toBeGreaterThan(0.005);
    clean(visited);
  });

  test("pause stops time, slow motion is slow, reset goes back", async () => {
    const visited = await visit(site, "");
    await simulated(visited, 1);
    await visited.page.keyboard.press("Space");
    const time = () => visited.page.evaluate(() => playground.theatre!.simulation.time);
    await new Promise((done) => setTimeout(done, 400));
    const stopped = await time();
    await new Promise((done) => setTimeout(done, 600));
    expect(await time()).toBe(stopped);
    await visited.page.keyboard.press("KeyR");
    expect((await state(visited)).x).toBeCloseTo(0, 5);
    await visited.page.keyboard.press("KeyL");
    await visited.page.keyboard.press("Space");
    await new Promise((done) => setTimeout(done, 2000));
    const slow = (await time()) - stopped;
    expect(slow).toBeGreaterThan(0);
    expect(slow).toBeLessThan(1);
  });

  test("the keyboard alone reaches every control", async () => {
    const visited = await visit(site, "");
    const wanted = await visited.page.evaluate(() => {
      const controls = document.querySelectorAll("button, select, input, a");
      return [...controls].filter((c) => !(c instanceof HTMLInputElement && c.type === "radio" && !c.checked)).length;
    });
    const reached = new Set<string>();
    for (let i = 0; i < wanted + 4; i++) {
      await visited.page.keyboard.press("Tab");
      const found = await visited.page.evaluate(() => {
        const controls = [...document.querySelectorAll("button, select, input, a")];
        const at = controls.indexOf(document.activeElement!);
        return at < 0 ? "" : `${at}`;
      });
      if (found) reached.add(found);
    }
    expect(reached.size).toBe(wanted);
  });

  test("on a phone everything fits, and the pad steers", async () => {
    const visited = await visit(site, "", PHONE);
    await reportFrames(visited, "phone, 390 x 844 twice as fine");
    const wide = await visited.page.evaluate(() => document.documentElement.scrollWidth);
    expect(wide).toBeLessThanOrEqual(PHONE.width);
    const { count, painted } = await colours(visited, "phone");
    expect(count).toBeGreaterThan(1500);
    expect(painted).toBeGreaterThan(0.005);
    const pad = (await (await visited.page.$("#pad"))!.boundingBox())!;
    const before = await visited.page.evaluate(() => playground.wishes.heading);
    const touch = await visited.page.touchscreen.touchStart(pad.x + pad.width / 2, pad.y + pad.height / 2);
    await touch.move(pad.x + pad.width - 4, pad.y + pad.height / 2);
    await visited.page.waitForFunction(`playground.wishes.heading !== ${before}`, PATIENCE);
    await touch.end();
    await simulated(visited, 1);
    expect((await state(visited)).falls).toBe(0);
    clean(visited);
  });

  test("a gamepad steers and pushes", async () => {
    const visited = await visit(site, "");
    await visited.page.evaluate(() => {
      const pad = { connected: true, axes: [1, 0, 0, 0], buttons: Array.from({ length: 16 }, () => ({ pressed: false })) };
      pad.buttons[0].pressed = true;
      Object.assign(window, { fake: pad });
      navigator.getGamepads = () => [pad as unknown as Gamepad];
    });
    await visited.page.waitForFunction("playground.pushes > 0", PATIENCE);
    await visited.page.waitForFunction("playground.wishes.speed > 1.8", PATIENCE);
    const { heading, speed } = await visited.page.evaluate(() => playground.wishes);
    expect(heading).not.toBe(0);
    expect(speed).toBeGreaterThan(1.8);
    await visited.page.evaluate("fake.axes[0] = 0.05"); // at rest, or nearly: the keys steer
    await held(visited, "KeyA", `playground.wishes.heading !== ${heading}`);
  });

  test("memory stays bounded over two minutes and many scenes", async () => {
    const visited = await visit(site, "", COARSE);
    const client = await visited.page.createCDPSession();
    const used = async () => {
      await client.send("HeapProfiler.collectGarbage");
      return visited.page.evaluate(() => {
        const { usedJSHeapSize } = (performance as unknown as { memory: { usedJSHeapSize: number } }).memory;
        const wasm = (playground.theatre!.walkers[0].motion.data.qpos as Float64Array).buffer.byteLength;
        const { geometries, textures } = playground.stage.renderer.info.memory;
        return { heap: usedJSHeapSize, wasm, geometries, textures };
      });
    };
    const change = async (ground: string, body: string) => {
      await visited.page.select("#ground", ground);
      await visited.page.select("#body", body);
      await visited.page.evaluate("playground.building");
      // What was never drawn is not on the graphics card, and is neither counted nor freed there.
      const frames = await visited.page.evaluate(() => playground.frames);
      await visited.page.waitForFunction(`playground.frames > ${frames}`, PATIENCE);
      await simulated(visited, 1);
    };
    const round = async () => {
      for (const ground of ["hills", "blocks", "ice", "flat"]) await change(ground, "long_shins");
      await change("flat", "plain");
    };
    await round();
    await round();
    const first = await used();
    const end = Date.now() + WATCHED;
    while (Date.now() < end) {
      await round();
      await new Promise((done) => setTimeout(done, 5000));
    }
    const last = await used();
    console.log("memory after two rounds and after two minutes:", first, last);
    expect(last.heap - first.heap).toBeLessThan(6e6);
    expect(last.wasm - first.wasm).toBeLessThan(20e6);
    expect(last.geometries).toBeLessThanOrEqual(first.geometries + 2);
    expect(last.textures).toBeLessThanOrEqual(first.textures + 2);
    clean(visited);
  });
});
