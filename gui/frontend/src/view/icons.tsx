/** Small drawings for groups of leaves and for statuses; the server has those of kinds. Each has a shape of its own, so that none is told by colour alone. */
import type { JSX } from "react";

import { kindOf } from "../model/kinds";
import type { Phase } from "../model/status";
import { groupOf } from "../model/words";

const DOT = <circle cx="8" cy="8" r="3.2" fill="currentColor" stroke="none" />;

/** Leaves by their group; those of groups that a project makes up have the dot of a leaf. */
export const GROUP_SHAPES: Record<string, JSX.Element> = {
  flow: <path d="M5 2.5c-2 0-1 5.5-3 5.5 2 0 1 5.5 3 5.5M11 2.5c2 0 1 5.5 3 5.5-2 0-1 5.5-3 5.5M6.5 8h3" />,
  arm: <path d="M2 14h5M4.5 14V9.5L9 5M9 5l4 2.5M10.3 3.7a1.8 1.8 0 1 1-2.6 2.6 1.8 1.8 0 0 1 2.6-2.6M13 5.5v4" />,
  hand: <path d="M8 14V9.5M8 9.5H4.5V3.5L6.5 2M8 9.5h3.5V3.5L9.5 2" />,
  grasp: <path d="M3 2v5a5 5 0 0 0 10 0V2M6.5 4.5h3v3h-3z" />,
  pose: <path d="M4 12V3M2.5 4.5 4 3l1.5 1.5M4 12h9M11.5 10.5 13 12l-1.5 1.500M4 12l6-6M7.8 5.800H10V8" />,
  scene: <path d="M8 1.8 13.5 5v6L8 14.2 2.5 11V5zM2.5 5 8 8l5.5-3M8 8v6" />,
  sensor: <path d="M6 12.500a6.4 6.4 0 0 0 0-9M9 14.500a9.2 9.2 0 0 0 0-13M3 10.500a3.5 3.5 0 0 0 0-5" />,
  perception: <path d="M1.5 8C4 3.5 12 3.5 14.5 8 12 12.5 4 12.5 1.5 8zM8 6a2 2 0 1 0 .01 0" />,
  component: <path d="M5.5 1.5v4M10.5 1.5v4M3.5 5.5h9V8a4.5 4.5 0 0 1-9 0zM8 12.5V15" />,
  messages: <path d="M2 3.500h12v9H2zM2 4l6 5 6-5" />,
  ros: <path d="M3 3.500v.01M3 8v.01M3 12.500v.01M8 3.500v.01M8 8v.01M8 12.500v.01M13 3.500v.01M13 8v.01M13 12.500v.01" strokeWidth="3" strokeLinecap="round" />,
  btcpp: <path d="M6.5 2h3v3h-3zM2 11h3v3H2zM11 11h3v3h-3zM8 5v3M3.500 11V8h9v3" />,
  nav2: <path d="M8 1.500l5 12.500-5-3-5 3z" />,
  smach: <path d="M5 5.500a2.500 2.500 0 1 1-.01 0zM11 10.500a2.500 2.500 0 1 1-.01 0zM7.500 5H11v5M8.500 13H5v-2.500" />,
};

/** A kind as the server draws it; a leaf by its group. */
export function KindIcon({ kind, id = "" }: { kind: string; id?: string }): JSX.Element {
  const icon = kindOf(kind)?.icon;
  return (
    <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
      {icon ? <path d={icon} /> : (GROUP_SHAPES[groupOf(id)] ?? DOT)}
    </svg>
  );
}

const PHASE_SHAPES: Record<Phase, JSX.Element> = {
  idle: <circle cx="8" cy="8" r="4.5" strokeDasharray="2 2.7" />,
  running: (
    <>
      <circle cx="8" cy="8" r="5.5" opacity="0.35" />
      <path className="spin" d="M8 2.5A5.5 5.5 0 0 1 13.5 8" />
    </>
  ),
  success: (
    <>
      <circle cx="8" cy="8" r="6.2" />
      <path d="M5 8.2 7.2 10.5 11 6" />
    </>
  ),
  failure: (
    <>
      <rect x="2" y="2" width="12" height="12" rx="1.5" />
      <path d="m5.2 5.2 5.6 5.6M10.8 5.2l-5.6 5.6" />
    </>
  ),
  ended: <path d="M8 2 14 8 8 14 2 8z" />,
  interrupted: <path d="M3 8h10M5.5 4v8M10.5 4v8" />,
  error: (
    <>
      <path d="M8 1.8 14.5 13.5h-13z" />
      <path d="M8 6v3.5M8 11.3v.4" />
    </>
  ),
};

export function PhaseIcon({ phase }: { phase: Phase }): JSX.Element {
  return (
    <svg className={`icon phase-${phase}`} viewBox="0 0 16 16" aria-hidden="true">
      {PHASE_SHAPES[phase]}
    </svg>
  );
}
