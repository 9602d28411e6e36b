/** Links say what is wished for, and whatever else they hold is ignored. */

import { describe, expect, test } from "vitest";

import { towards } from "../src/input/steering";
import { wrapped } from "../src/rotations";
import { hashOf, wishesOf } from "../src/wishes";
import { index, specification } from "./site";

const read = (hash: string) => wishesOf(hash, index, specification);

test("a link restores every wish", () => {
  const link =
    "#base=run&body=long_shins&lock=right_knee&ground=ice&run-lockedrightknee=-0.25&run-longshins=0.75" +
    "&speed=2.4&heading=1.57&force=700&compare&slow";
  expect(hashOf(read(link))).toBe(link);
});

test("an empty link is the walk on flat ground", () => {
  const wishes = read("");
  expect([wishes.base, wishes.body, wishes.lock, wishes.ground]).toEqual(["walk", "plain", "plain", "flat"]);
  expect([wishes.strengths, wishes.compare, wishes.slow, wishes.heading]).toEqual([{}, false, false, null]);
});

test("without a speed, it is the middle of what the strongest adaptation learned", () => {
  expect(read("").speed).toBe(1.25);
  expect(read("#walk-penguin=1").speed).toBeLessThan(0.8);
  expect(read("#walk-penguin=0.1").speed).toBe(1.25);
});

describe.each(["#base=fly", "#body=<b>", "#speed=fast", "#speed=&force=", "#run-longshins=1", "#constructor=1&%%%"])(
  "%s",
  (hash) => {
    test("asks for nothing unusual", () => expect(read(hash)).toEqual(read("")));
  },
);

test("numbers stay within what the sliders offer", () => {
  expect(read("#walk-stoop=9").strengths).toEqual({ "walk-stoop": 1.5 });
  expect(read("#walk-stoop=-9").strengths).toEqual({ "walk-stoop": -0.5 });
  expect(read("#force=1e9").force).toBe(1000);
});

test("a stick points where the camera looks, and pushes as far as the speed", () => {
  const now = { heading: 0, speed: 1 };
  expect(towards([0.05, 0.05], now, [0.5, 2], 0)).toBe(now);
  expect(towards([0, 1], now, [0.5, 2], 0.3)).toEqual({ heading: wrapped(0.3), speed: 2 });
  expect(towards([1, 0], now, [0.5, 2], 0).heading).toBeCloseTo(-Math.PI / 2);
});
