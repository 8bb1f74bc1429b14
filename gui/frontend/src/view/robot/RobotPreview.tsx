/** A robot before it runs: in 3D, its joints moved by sliders within their limits, its named states, what its files said. */
import "./robot.css";

import { type JSX, type KeyboardEvent, useEffect, useMemo, useRef, useState } from "react";

import type { GeometryView } from "../../protocol/generated";
import { makeSpace, type Space } from "./space";

interface PreviewProps {
  readonly view: GeometryView | null;
  /** Whether the joints can be moved. */
  readonly moves?: boolean;
}

export default function RobotPreview({ view, moves = false }: PreviewProps): JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null);
  const space = useRef<Space | null>(null);
  const [error, setError] = useState("");
  const [joints, setJoints] = useState<ReadonlyMap<string, number>>(new Map());
  useEffect(() => setJoints(new Map()), [view]);
  useEffect(() => {
    if (!canvas.current || !view || view.error) return;
    try {
      space.current = makeSpace(canvas.current, view);
      space.current.fit();
    } catch (why) {
      setError(`This browser cannot draw in 3D: ${why instanceof Error ? why.message : String(why)}`);
    }
    return () => {
      space.current?.close();
      space.current = null;
    };
  }, [view]);
  useEffect(() => space.current?.show({ t: 0, joints, scene: {}, bodies: {} }, [], [], false), [view, joints]);
  function onKeyDown(event: KeyboardEvent): void {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (turn) space.current?.turn(turn[0] ?? 0, turn[1] ?? 0);
    else if (event.key === "+" || event.key === "-") space.current?.nearer(event.key === "+" ? 0.85 : 1.18);
    else return;
    event.preventDefault();
  }
  const fault = error || view?.error;
  const movable = view === null ? [] : view.joints.filter((joint) => joint.type !== "fixed" && !joint.mimic);
  return (
    <div className={moves ? "preview preview-moves" : "preview"}>
      <div className="robot-canvas">
        {fault ? (
          <p className="fault padded" role="alert">{fault}</p>
        ) : view === null ? (
          <p className="hint loading" role="status">Loading the robot's shape ...</p>
        ) : (
          <canvas ref={canvas} tabIndex={0} role="application" aria-roledescription="3D drawing" aria-label={`${view.name}: ${movable.length} joints. Arrow keys turn it, plus and minus go nearer and away.`} onKeyDown={onKeyDown} />
        )}
      </div>
      {moves && view && !view.error && <Joints view={view} joints={joints} set={setJoints} />}
    </div>
  );
}

interface JointsProps {
  readonly view: GeometryView;
  readonly joints: ReadonlyMap<string, number>;
  readonly set: (joints: ReadonlyMap<string, number>) => void;
}

function Joints({ view, joints, set }: JointsProps): JSX.Element {
  const known = useMemo(() => new Map(view.joints.map((joint) => [joint.name, joint])), [view]);
  return (
    <div className="scroll joints" tabIndex={0} role="group" aria-label="Joints and named states">
      <button onClick={() => set(new Map())}>All at rest</button>
      {Object.entries(view.groups).map(([group, names]) => (
        <details key={group} open={Object.keys(view.groups).length < 3 || names.length < 8}>
          <summary>
            {group} <span className="hint">{names.length} {names.length === 1 ? "joint" : "joints"}</span>
          </summary>
          <p className="states">
            {Object.entries(view.states[group] ?? {}).map(([name, at]) => (
              <button key={name} title={`Where ${group} is ${name}`} onClick={() => set(new Map([...joints, ...Object.entries(at)]))}>
                {name}
              </button>
            ))}
          </p>
          {names.map((name) => {
            const joint = known.get(name);
            if (!joint) return null;
            const [low, high] = joint.limits.length === 2 && joint.limits[0] !== joint.limits[1] ? (joint.limits as [number, number]) : [-Math.PI, Math.PI];
            const at = joints.get(name) ?? view.rest[name] ?? 0;
            const unit = joint.type === "prismatic" ? "m" : "rad";
            return (
              <label key={name} className="joint">
                <span>{name}</span>
                <input type="range" aria-label={name} min={low} max={high} step={(high - low) / 200} value={at} onChange={(event) => set(new Map(joints).set(name, Number(event.target.value)))} />
                <output>
                  {at.toFixed(3)} {unit}
                </output>
                <span className="hint">
                  {low.toFixed(2)} to {high.toFixed(2)}
                </span>
              </label>
            );
          })}
        </details>
      ))}
      <h3>What its files said</h3>
      {view.findings.length === 0 ? (
        <p className="phase-success">✓ Nothing had to be mended or left out.</p>
      ) : (
        <ul aria-label="What its files said">
          {view.findings.map((finding) => (
            <li key={finding}>{finding}</li>
          ))}
        </ul>
      )}
    </div>
  );
}
