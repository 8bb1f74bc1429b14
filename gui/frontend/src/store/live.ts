/** What runs beside the editor: topics of the ROS graph, and the named messages of a running server. */
import { create } from "zustand";

import { valueAt } from "../model/shapes";
import type { CameraTopics } from "../model/topics";
import { server } from "../protocol/client";
import type { LiveMessages, TopicsView, TopicView } from "../protocol/generated";
import { openSetup, setValue, useSetup } from "./setup";

export interface LiveStore {
  readonly topics: TopicsView | null;
  readonly looking: boolean;
  readonly messages: LiveMessages | null;
  /** What went wrong with the last wish, or what was done. */
  readonly trouble: string;
  readonly said: string;
}

export const useLive = create<LiveStore>()(() => ({ topics: null, looking: false, messages: null, trouble: "", said: "" }));

export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

export async function lookAtTopics(): Promise<void> {
  if (useLive.getState().looking) return;
  useLive.setState({ looking: true });
  try {
    useLive.setState({ topics: await server.topics() });
  } catch (error) {
    useLive.setState({ topics: { topics: [], domain: "", trouble: messageOf(error) } });
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
    useLive.setState({ messages: { served: false, ours: false, stores: [], messages: [], domain: "", trouble: messageOf(error) } });
  }
}

/** Do something with the running server, say what came of it, and look again. */
export async function wished(work: () => Promise<{ trouble: string; said?: string }>): Promise<boolean> {
  useLive.setState({ trouble: "", said: "" });
  try {
    const { trouble, said = "" } = await work();
    useLive.setState({ trouble, said });
    await lookAtMessages();
    return trouble === "";
  } catch (error) {
    useLive.setState({ trouble: messageOf(error) });
    return false;
  }
}
