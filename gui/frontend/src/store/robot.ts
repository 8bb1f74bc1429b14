/** The robot in 3D: what it looks like, how the shown run has moved it, and the poses among the variables. */
import { create } from "zustand";

import { Motion } from "../model/motion";
import { server } from "../protocol/client";
import type { CloudView, GeometryView, NamedPlace } from "../protocol/generated";
import { messageOf } from "./live";

export interface RobotStore {
  readonly open: boolean;
  readonly view: GeometryView | null;
  readonly run: string;
  readonly motion: Motion;
  /** Grows with every piece of the motion. */
  readonly version: number;
}

export const useRobot = create<RobotStore>()(() => ({ open: false, view: null, run: "", motion: new Motion(), version: 0 }));

export function setRobotOpen(open: boolean): void {
  useRobot.setState({ open });
}

export async function loadGeometry(): Promise<void> {
  try {
    useRobot.setState({ view: await server.geometry() });
  } catch (error) {
    useRobot.setState({ view: { name: "", links: [], joints: [], meshes: [], rest: {}, grasp: {}, trouble: messageOf(error) } });
  }
}

/** Read what is new in the record of a run's motion; all of it for another run. */
export async function readMotion(run: string): Promise<void> {
  if (useRobot.getState().run !== run) useRobot.setState({ run, motion: new Motion(), version: 0 });
  const { motion } = useRobot.getState();
  try {
    for (let before = -1; before !== motion.next; ) {
      before = motion.next;
      const piece = await server.motion(run, before);
      if (useRobot.getState().motion !== motion) return;
      motion.add(piece);
      if (piece.samples.length > 0) useRobot.setState(({ version }) => ({ version: version + 1 }));
    }
  } catch {
    // The next look tries again; the page says elsewhere that the server is gone.
  }
}

/** A cloud among the variables. */
export interface NamedCloud extends CloudView {
  readonly name: string;
}

const SEEN = /^(PointCloud|RgbdFrame)$/;
/** The clouds that were asked for last: each is up to half a megabyte. */
const MOST_CLOUDS = 8;
const clouds = new Map<string, Promise<NamedCloud | null>>();

/** The cloud that a write wrote; null of other types, and of one that wasn't kept. */
export function cloudOf(run: string, seq: number, type: string, name: string): Promise<NamedCloud | null> {
  if (!SEEN.test(type)) return Promise.resolve(null);
  const key = `${run}/${seq}`;
  let found = clouds.get(key);
  if (!found) {
    found = server.cloud(run, seq).then(
      (cloud) => ({ ...cloud, name }),
      () => null,
    );
    clouds.set(key, found);
    const oldest = clouds.keys().next().value;
    if (clouds.size > MOST_CLOUDS && oldest !== undefined) clouds.delete(oldest);
  }
  return found;
}

const POSED = /\b(Pose|Grasp)\b/;
const places = new Map<string, Promise<NamedPlace[]>>();

/** Poses in the value that a write wrote; of other types none. */
export function placesOf(run: string, seq: number, type: string, name: string): Promise<NamedPlace[]> {
  if (!POSED.test(type)) return Promise.resolve([]);
  const key = `${run}/${seq}`;
  let found = places.get(key);
  if (!found) {
    found = server.value(run, seq).then(
      (view) => view.places.map((place) => ({ ...place, name: `${name} ${place.name}`.trim() })),
      () => [],
    );
    places.set(key, found);
  }
  return found;
}
