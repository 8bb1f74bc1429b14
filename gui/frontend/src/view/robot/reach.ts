/** Where an arm's joints have to be for its hand to be at a pose: damped least squares over a numeric Jacobian, from several starts. */
import { Euler, Matrix4, Quaternion, Vector3 } from "three";

import type { FrameView, GeometryView, JointView } from "../../protocol/generated";
import { makeRobot } from "./body";

export interface Pose {
  readonly position: readonly number[];
  /** Roll, pitch, yaw about the fixed axes [rad]. */
  readonly turn: readonly number[];
}

export interface Reached {
  readonly joints: ReadonlyMap<string, number>;
  /** How far from the pose it still is [m], [rad]. */
  readonly off: readonly [number, number];
}

type Joints = ReadonlyMap<string, number>;

export const NEAR = 0.002;
const STEP = 1e-4;
const ROUNDS = 80;
const DAMPING = 0.02;
const LARGEST = 0.3;

/** An arm whose hand is moved: what the hand's frame is, and the joints that carry it there. */
export function makeReach(view: GeometryView, frame: FrameView): { where(joints: Joints): Pose; reach(pose: Pose, from: Joints): Reached } {
  const bare = makeRobot({ ...view, meshes: [], links: Object.fromEntries(Object.keys(view.links).map((name) => [name, []])) });
  const [x = 0, y = 0, z = 0, w = 1, i = 0, j = 0, k = 0] = frame.at;
  const inside = new Matrix4().compose(new Vector3(x, y, z), new Quaternion(i, j, k, w), new Vector3(1, 1, 1));
  const mine = new Set(view.groups[frame.group] ?? []);
  const moved = view.joints.filter((joint) => mine.has(joint.name) && !joint.mimic);
  function at(joints: Joints): [Vector3, Quaternion] {
    bare.stand(joints);
    bare.root.updateMatrixWorld(true);
    const place = new Matrix4().multiplyMatrices(bare.links.get(frame.link)?.matrixWorld ?? new Matrix4(), inside);
    return [new Vector3().setFromMatrixPosition(place), new Quaternion().setFromRotationMatrix(place)];
  }
  function where(joints: Joints): Pose {
    const [position, quaternion] = at(joints);
    const { x: r, y: p, z: yaw } = new Euler().setFromQuaternion(quaternion, "ZYX");
    return { position: position.toArray(), turn: [r, p, yaw] };
  }
  function descend(position: Vector3, quaternion: Quaternion, from: Joints): Reached {
    const joints = new Map(from);
    for (const joint of moved) joints.set(joint.name, from.get(joint.name) ?? view.rest[joint.name] ?? 0);
    let error = apart(at(joints), [position, quaternion]);
    for (let round = 0; round < ROUNDS && norm(error) > NEAR / 10; round++) {
      const columns = moved.map((joint) => {
        const now = joints.get(joint.name) ?? 0;
        const next = apart(at(new Map(joints).set(joint.name, now + STEP)), [position, quaternion]);
        return error.map((each, row) => (each - (next[row] ?? 0)) / STEP);
      });
      const square = error.map((_, row) => error.map((_, column) => columns.reduce((sum, each) => sum + (each[row] ?? 0) * (each[column] ?? 0), row === column ? DAMPING ** 2 : 0)));
      const pull = solved(square, error);
      columns.forEach((column, number) => {
        const joint = moved[number] as JointView;
        const step = column.reduce((sum, each, row) => sum + each * (pull[row] ?? 0), 0);
        joints.set(joint.name, within(joint, (joints.get(joint.name) ?? 0) + Math.max(-LARGEST, Math.min(LARGEST, step))));
      });
      error = apart(at(joints), [position, quaternion]);
    }
    return { joints, off: [Math.hypot(...error.slice(0, 3)), Math.hypot(...error.slice(3))] };
  }
  return {
    where,
    reach: ({ position, turn }, from) => {
      const [px = 0, py = 0, pz = 0] = position;
      const [r = 0, p = 0, yaw = 0] = turn;
      const goal: [Vector3, Quaternion] = [new Vector3(px, py, pz), new Quaternion().setFromEuler(new Euler(r, p, yaw, "ZYX"))];
      const starts: Joints[] = [from, ...Object.values(view.states[frame.group] ?? {}).map((state) => new Map([...from, ...Object.entries(state)]))];
      let best: Reached | null = null;
      for (const start of starts) {
        const found = descend(...goal, start);
        if (best === null || found.off[0] + found.off[1] < best.off[0] + best.off[1]) best = found;
        if (isNear(best)) break;
      }
      return best as Reached;
    },
  };
}

export function isNear({ off }: Reached): boolean {
  return off[0] < NEAR && off[1] < 5 * NEAR;
}

/** From where it is to where it shall be: three lengths [m], and a rotation vector [rad]. */
function apart([position, quaternion]: [Vector3, Quaternion], [goal, turned]: [Vector3, Quaternion]): number[] {
  const turn = turned.clone().multiply(quaternion.clone().invert());
  if (turn.w < 0) turn.set(-turn.x, -turn.y, -turn.z, -turn.w);
  const sine = Math.hypot(turn.x, turn.y, turn.z);
  const scale = sine < 1e-9 ? 2 : (2 * Math.atan2(sine, turn.w)) / sine;
  return [goal.x - position.x, goal.y - position.y, goal.z - position.z, turn.x * scale, turn.y * scale, turn.z * scale];
}

function norm(error: readonly number[]): number {
  return Math.hypot(...error);
}

function within(joint: JointView, position: number): number {
  const [low = -Infinity, high = Infinity] = joint.limits;
  return low < high ? Math.max(low, Math.min(high, position)) : position;
}

/** Solve square linear equations by elimination with pivots. */
function solved(matrix: number[][], right: readonly number[]): number[] {
  const rows = matrix.map((row, at) => [...row, right[at] ?? 0]);
  const count = rows.length;
  const cell = (row: number, column: number): number => rows[row]?.[column] ?? 0;
  for (let at = 0; at < count; at++) {
    let pivot = at;
    for (let row = at + 1; row < count; row++) if (Math.abs(cell(row, at)) > Math.abs(cell(pivot, at))) pivot = row;
    [rows[at], rows[pivot]] = [rows[pivot] as number[], rows[at] as number[]];
    for (let row = 0; row < count; row++) {
      if (row === at) continue;
      const factor = cell(row, at) / cell(at, at);
      rows[row] = (rows[row] as number[]).map((each, column) => each - factor * cell(at, column));
    }
  }
  return rows.map((row, at) => (row[count] ?? 0) / cell(at, at));
}
