/** The robot in 3D at the shown moment: joints as measured, objects, what hands hold, frames and poses; also in words. */
import { type JSX, type KeyboardEvent, useEffect, useMemo, useRef, useState } from "react";

import { newtonsOf, type Press, REACH, type Stand } from "../../model/timeline";
import { seconds } from "../../model/words";
import type { NamedPlace, SceneItem } from "../../protocol/generated";
import { cloudOf, loadGeometry, type NamedCloud, placesOf, readMotion, setRobotOpen, useRobot } from "../../store/live";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { useDark } from "../hooks";
import { makeSpace, type Side, type Space, type Spot } from "./space";

const PERIOD = 150;
const NONE: readonly NamedCloud[] = [];
const SIDES: readonly [Side, string][] = [
  ["front", "Front"],
  ["side", "Side"],
  ["above", "Above"],
  ["hand", "Hand"],
];

export default function RobotView(): JSX.Element {
  const view = useRobot((s) => s.view);
  const stand = useStand();
  const places = usePlaces();
  const found = useClouds();
  // Where the frame of another cloud is, nobody has told.
  const clouds = useMemo(() => found.filter((cloud) => cloud.frame === "world" || (view !== null && cloud.frame in view.links)), [found, view]);
  const [shown, setShown] = useState(true);
  const [frames, setFrames] = useState(false);
  const [error, setError] = useState("");
  const dark = useDark();
  const [grasps, setGrasps] = useState<ReadonlyMap<string, readonly [number, number, number]>>(new Map());
  const canvas = useRef<HTMLCanvasElement>(null);
  const space = useRef<Space | null>(null);
  useEffect(() => void loadGeometry(), []);
  useEffect(() => {
    if (!canvas.current || !view || view.error) return;
    try {
      space.current = makeSpace(canvas.current, view);
    } catch (error) {
      setError(`This browser cannot draw in 3D: ${error instanceof Error ? error.message : String(error)}`);
    }
    return () => {
      space.current?.close();
      space.current = null;
    };
  }, [view]);
  useEffect(() => {
    space.current?.show(stand, places, shown ? clouds : NONE, frames);
    if (space.current) setGrasps(space.current.grasps());
  }, [view, stand, places, clouds, shown, frames, dark]);
  function onKeyDown(event: KeyboardEvent): void {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (turn) space.current?.turn(turn[0] ?? 0, turn[1] ?? 0);
    else if (event.key === "+" || event.key === "-") space.current?.nearer(event.key === "+" ? 0.85 : 1.18);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
  const close = (): void => {
    setRobotOpen(false);
    if (usePage.getState().view === "robot") usePage.getState().setView("tree");
  };
  const origin = useRun((s) => s.history.start);
  const known = stand && view ? view.joints.filter((joint) => stand.joints.has(joint.name)).length : 0;
  const said = view === null ? "Fetching the robot ..." : view.error || (stand === null ? `${view.name} at rest: the run has measured nothing` : known === 0 ? `${view.name} at rest: the joints of this run's robot aren't its joints (a fake?)` : `${view.name}: ${known} joints as measured`);
  const at = stand && known > 0 && !view?.error ? ` at ${seconds(Math.max(0, stand.t - origin))}` : "";
  return (
    <section className="robot-view" aria-label="Robot in 3D">
      <div className="edit-bar" role="toolbar" aria-label="Camera">
        {SIDES.filter(([side]) => side !== "hand" || grasps.size > 0).map(([side, label]) => (
          <button key={side} onClick={() => space.current?.from(side)}>
            {label}
          </button>
        ))}
        <label className="robot-frames">
          <input type="checkbox" checked={frames} onChange={(event) => setFrames(event.target.checked)} /> Frames
        </label>
        {clouds.length > 0 && (
          <label className="robot-frames">
            <input type="checkbox" checked={shown} onChange={(event) => setShown(event.target.checked)} /> Clouds
          </label>
        )}
        <button className="robot-close" aria-label="Close" title="Close" onClick={close}>
          ✕
        </button>
      </div>
      <p className={view?.error ? "fault padded" : "hint padded"} role="status" aria-label="What is drawn">
        {error || said}
        {/* The moment isn't told: it changes all the time. */}
        {!error && <span aria-hidden="true">{at}</span>}
      </p>
      <div className="robot-canvas">
        {view === null && <p className="hint loading">Loading the robot's shape ...</p>}
        {view !== null && !view.error && (
          <canvas ref={canvas} tabIndex={0} role="application" aria-roledescription="3D drawing" aria-label={`${said}${at}. Arrow keys turn it, plus and minus go nearer and away.`} onKeyDown={onKeyDown} />
        )}
        {stand && <Legend stand={stand} />}
      </div>
      {stand && view && !view.error && <InWords stand={stand} places={places} clouds={found} drawn={clouds} grasps={grasps} />}
    </section>
  );
}

interface Words {
  readonly stand: Stand;
  readonly places: readonly NamedPlace[];
  readonly clouds: readonly NamedCloud[];
  readonly drawn: readonly NamedCloud[];
  readonly grasps: ReadonlyMap<string, readonly number[]>;
}

function InWords({ stand, places, clouds, drawn, grasps }: Words): JSX.Element {
  const items = Object.entries(stand.scene);
  return (
    <details className="robot-words">
      <summary>
        {items.length} {items.length === 1 ? "object" : "objects"}, {places.length} {places.length === 1 ? "pose" : "poses"}
        {clouds.length > 0 && `, ${clouds.length} ${clouds.length === 1 ? "cloud" : "clouds"}`}, in words
      </summary>
      <div className="scroll" tabIndex={0} role="group" aria-label="The drawing in words">
        <ul className="plain">
          {[...grasps].map(([hand, at]) => (
            <li key={hand}>
              grasp frame of {hand}: {numbers(at)} m
            </li>
          ))}
          {stand.ways[0] && (
            <li>
              {stand.ways[0].arm} {stand.ways[0].over ? "has gone" : "goes"} a way of {stand.ways[0].points.length} points
            </li>
          )}
          {stand.plans.length > 0 && (
            <li>
              {stand.plans.length} {stand.plans.length === 1 ? "motion is" : "motions are"} planned and not begun
            </li>
          )}
          {[...stand.touch].filter(([link]) => !stand.press.some((press) => press.link === link)).map(([link, force]) => (
            <li key={link}>
              {link} touches with {force.toFixed(1)} N
            </li>
          ))}
          {together(stand.press).map(({ link, other, at, force }) => (
            <li key={`${link}/${other}`}>
              {link} presses on {other} with {Math.hypot(...force).toFixed(1)} N at {numbers(at)} m, towards {numbers(force.map((each) => each / Math.hypot(...force)))}
            </li>
          ))}
          {items.map(([name, item]) => (
            <li key={name}>
              {name}: {KINDS[item.kind]} {numbers(item.size)} m {item.hand ? `held by ${item.hand}` : `at ${numbers(item.at.slice(0, 3))} m`}
            </li>
          ))}
          {clouds.map((cloud) => (
            <li key={cloud.name}>
              {cloud.name}: cloud of {cloud.of} points in {cloud.frame}
              {!drawn.includes(cloud) && ", which isn't drawn: no link of the robot is called so"}
            </li>
          ))}
          {places.map((place) => (
            <li key={place.name}>
              {place.name}: {numbers(place.at.slice(0, 3))} m in {place.frame}
            </li>
          ))}
        </ul>
      </div>
    </details>
  );
}

/** What the lines and arrows that are drawn just now mean. */
function Legend({ stand }: { stand: Stand }): JSX.Element | null {
  const goes = stand.ways.some((way) => !way.over);
  const marks: [string, string][] = [
    ...(goes ? [["way", "goes"] as [string, string]] : []),
    ...(goes || stand.plans.length > 0 ? [["plan", "planned"] as [string, string]] : []),
    ...(stand.ways.some((way) => way.over) ? [["gone", "gone"] as [string, string]] : []),
    ...(stand.press.length > 0 ? [["force", `${REACH * 100} cm = ${newtonsOf(stand.hardest)} N`] as [string, string]] : []),
  ];
  if (marks.length === 0) return null;
  return (
    <ul className="robot-legend" aria-label="Legend">
      {marks.map(([kind, said]) => (
        <li key={kind} className={`is-${kind}`}>
          {said}
        </li>
      ))}
    </ul>
  );
}

/** Of a link and what it presses on one contact: all its force, and the middle of it. */
function together(points: readonly Press[]): Press[] {
  const found = new Map<string, Press[]>();
  for (const point of points) found.set(`${point.link}/${point.other}`, [...(found.get(`${point.link}/${point.other}`) ?? []), point]);
  return [...found.values()].map((all) => {
    const weights = all.map(({ force }) => Math.hypot(...force));
    const sum = weights.reduce((one, other) => one + other, 0) || 1;
    const axes = [0, 1, 2];
    const at = axes.map((axis) => all.reduce((total, point, number) => total + (point.at[axis] ?? 0) * ((weights[number] ?? 0) / sum), 0));
    return { ...(all[0] as Press), at, force: axes.map((axis) => all.reduce((total, point) => total + (point.force[axis] ?? 0), 0)) };
  });
}

const KINDS: Record<SceneItem["kind"], string> = { box: "box", cylinder: "cylinder", sphere: "sphere", mesh: "mesh within", cells: "cells of" };

function numbers(values: readonly number[]): string {
  return `(${values.map((value) => (Math.round(value * 1000) / 1000 + 0).toFixed(3)).join(", ")})`;
}

/** Where everything is at the moment that is shown; the latest that was measured while a run is followed. */
function useStand(): Stand | null {
  const run = useRun((s) => s.record?.id);
  const live = useRun((s) => !s.complete);
  const following = useRun((s) => s.cursor === null);
  const t = useRun((s) => s.moment.t);
  const origin = useRun((s) => s.history.start);
  const version = useRobot((s) => s.version);
  const known = useRobot((s) => s.run);
  const [stand, setStand] = useState<Stand | null>(null);
  useEffect(() => {
    if (run === undefined) return;
    let left = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    async function look(id: string): Promise<void> {
      if (document.visibilityState === "visible") await readMotion(id);
      if (!left && live) timer = setTimeout(() => void look(id), PERIOD);
    }
    void look(run);
    return () => {
      left = true;
      clearTimeout(timer);
    };
  }, [run, live]);
  useEffect(() => {
    const { motion } = useRobot.getState();
    setStand(run === undefined || known !== run ? null : motion.at(following ? Number.POSITIVE_INFINITY : t + origin));
  }, [run, known, version, following, t, origin]);
  return stand;
}

/** The poses and grasps among the variables at the shown moment. */
function usePlaces(): readonly Spot[] {
  const run = useRun((s) => s.record?.id);
  const moment = useRun((s) => s.moment);
  const version = useRun((s) => s.version);
  const [places, setPlaces] = useState<readonly Spot[]>([]);
  useEffect(() => {
    let left = false;
    const asked = run === undefined ? [] : [...moment.variables].map(async ([key, { seq, type }]) => ({ seq, type, found: await placesOf(run, seq, type, key.split(/[:/]/).at(-1) ?? key) }));
    void Promise.all(asked).then((all) => {
      // Of each type the value that was written last is today's.
      const last = (type: string): number => Math.max(...all.filter((each) => each.type === type && each.found.length > 0).map(({ seq }) => seq));
      if (!left) setPlaces(all.flatMap(({ seq, type, found }) => found.map((place) => ({ ...place, over: seq < last(type) }))));
    });
    return () => {
      left = true;
    };
  }, [run, moment, version]);
  return places;
}

/** The clouds among the variables at the shown moment; asked for again only when one was written. */
function useClouds(): readonly NamedCloud[] {
  const run = useRun((s) => s.record?.id);
  const moment = useRun((s) => s.moment);
  const version = useRun((s) => s.version);
  const [clouds, setClouds] = useState<readonly NamedCloud[]>(NONE);
  useEffect(() => {
    let left = false;
    const asked = run === undefined ? [] : [...moment.variables].map(([key, value]) => cloudOf(run, value.seq, value.type, key.split(/[:/]/).at(-1) ?? key));
    void Promise.all(asked).then((answers) => {
      const now = answers.filter((cloud) => cloud !== null && cloud.points !== "") as NamedCloud[];
      if (!left) setClouds((before) => (now.length === before.length && now.every((cloud, at) => cloud === before[at]) ? before : now));
    });
    return () => {
      left = true;
    };
  }, [run, moment, version]);
  return clouds;
}
