/** What runs beside the editor: topics of the ROS graph, and the named messages of a running server. */
import { create } from "zustand";
import { valueAt } from "../model/shapes";
import { Motion } from "../model/timeline";
import type { CameraTopics } from "../model/parts";
import { server } from "../protocol/client";
import type { CloudView, GeometryView, LiveMessages, NamedPlace, TopicsView, TopicView } from "../protocol/generated";
import { openSetup, setValue, useSetup } from "./setup";

export interface LiveStore {
  readonly topics: TopicsView | null;
  readonly looking: boolean;
  readonly messages: LiveMessages | null;
  /** What went wrong with the last request, or what was done. */
  readonly error: string;
  readonly said: string;
}

export const useLive = create<LiveStore>()(() => ({ topics: null, looking: false, messages: null, error: "", said: "" }));

export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

export async function lookAtTopics(): Promise<void> {
  if (useLive.getState().looking) return;
  useLive.setState({ looking: true });
  try {
    useLive.setState({ topics: await server.topics() });
  } catch (error) {
    useLive.setState({ topics: { topics: [], domain: "", error: messageOf(error) } });
  } finally {
    useLive.setState({ looking: false });
  }
}

/** Enter a topic as an output of a sensor in grip.yaml; the person sees it there, and saves. */
export async function useAsSensor(topic: TopicView, sensor: string, output: string): Promise<void> {
  await openSetup("grip.yaml");
  await setValue(["sensors", sensor, "topics", output], { topic: topic.name, type: topic.value });
}

/** Enter the topics of a camera, which a sensor says by name; the person sees it there, and saves. */
export async function useAsCamera(camera: CameraTopics, sensor: string): Promise<void> {
  await openSetup("grip.yaml");
  const view = useSetup.getState().view;
  // In simulation the same sensor is a camera of the world.
  if (valueAt(view?.data, ["sensors", sensor]) === undefined) await setValue(["sensors", sensor], { camera: view?.options["sensors/*/camera"]?.[0] ?? sensor });
  const found = Object.fromEntries(Object.entries(camera).filter(([, topic]) => topic !== ""));
  await setValue(["ros", "cameras", sensor], found);
}

export async function lookAtMessages(): Promise<void> {
  try {
    useLive.setState({ messages: await server.liveMessages() });
  } catch (error) {
    useLive.setState({ messages: { served: false, ours: false, stores: [], messages: [], domain: "", error: messageOf(error) } });
  }
}

/** Do something with the running server, say what came of it, and look again. */
export async function wished(work: () => Promise<{ error: string; said?: string }>): Promise<boolean> {
  useLive.setState({ error: "", said: "" });
  try {
    const { error, said = "" } = await work();
    useLive.setState({ error, said });
    await lookAtMessages();
    return error === "";
  } catch (error) {
    useLive.setState({ error: messageOf(error) });
    return false;
  }
}

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
    useRobot.setState({ view: { name: "", links: {}, joints: [], meshes: [], rest: {}, grasp: {}, groups: {}, states: {}, findings: [], error: messageOf(error) } });
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
