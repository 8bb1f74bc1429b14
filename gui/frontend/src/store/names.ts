/** What the project's files name, for the parameters of leaves: asked once somebody looks at a leaf, and again when a file was saved. */
import { create } from "zustand";

import { optionsAt } from "../model/shapes";
import { server } from "../protocol/client";

interface Names {
  readonly places: Readonly<Record<string, readonly string[]>>;
  readonly asked: boolean;
}

export const useNames = create<Names>()(() => ({ places: {}, asked: false }));

/** Ask, unless that was done; without an answer nothing is offered. */
export function needNames(): void {
  if (useNames.getState().asked) return;
  useNames.setState({ asked: true });
  loadNames();
}

/** The files are others now. */
export function renewNames(): void {
  if (useNames.getState().asked) loadNames();
}

/** What may stand in a parameter of a node; undefined where nothing is known. */
export function namesFor(places: Names["places"], node: string, parameter: string): readonly string[] | undefined {
  return optionsAt(places, [...node.split("/"), parameter]);
}

function loadNames(): void {
  server.names().then(
    ({ places }) => useNames.setState({ places }),
    () => useNames.setState({ asked: false }),
  );
}
