/** The JSON files that web/emit.py writes. */

export interface Specification {
  version: number;
  size: number;
  frames: number;
  links: string[];
  link_size: number;
  link: Record<"position" | "orientation" | "velocity" | "angular_velocity", Part>;
  goal_offset: number;
  goal: Record<"direction" | "distance" | "speed", Part>;
  heightmap: { size: number; grid: number; ahead: number; aside: number };
  joints: string[];
  control_hz: number;
  physics_steps: number;
  /** Names of sensors that tell a touch, with the links that it may be. */
  fall_sensors: Record<string, string[]>;
  task: { goal_radius: number; no_direction: number; sharpness: number; edge: number };
  bases: Record<string, { speeds: [number, number]; held_seconds: number }>;
  push: { link: string; force: number; seconds: number };
}

interface Part {
  offset: number;
  size: number;
  unit: string;
  words: string;
}

export interface Listed {
  name: string;
  title: string;
  words: string;
  heightmap: boolean;
  body: string;
  lock: string;
  ground: string;
  /** Preferred speeds that it learned [m/s]. */
  speeds: [number, number];
}

export interface Index {
  bodies: Record<string, string>;
  locks: Record<string, string>;
  grounds: Record<string, string>;
  bases: Record<string, Listed[]>;
}

export interface Start {
  qpos: number[];
  qvel: number[];
  heading: number;
  history: number[];
}

/** A character on a ground. `exact` holds the model's fields whose values the text rounds. */
export interface Scene {
  mjcf: string;
  joints: string[];
  exact: Record<string, number[]> & { timestep: number };
  starts: Record<string, Start>;
}

export interface GroundFile {
  friction: number;
  /** A link that touches from higher than this [m] has not fallen; null if any touch is a fall. */
  fall_height: number | null;
  reach: number | null;
  surface?: { rows: number; columns: number; grid: number; low: [number, number]; lowest: number; highest: number };
  blocks?: Record<"x" | "y" | "half_x" | "half_y" | "yaw" | "top", number[]>;
}
