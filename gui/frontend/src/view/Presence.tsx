/** Who looks on, by name and colour, and who holds control; shown as soon as there is somebody to share it with. */
import type { JSX } from "react";
import { PAGE } from "../protocol/client";
import type { Viewer } from "../protocol/generated";
import { askForName } from "../store/actions";
import { initials, selectedBy } from "../model/others";
import { useOthersAt } from "../store/others";
import { holderText, isHeldElsewhere, useRunning } from "../store/runDesk";
import { giveBack, takeOver } from "../store/running";

/** More are counted, and named in the tip of the count. */
const SHOWN = 4;

export function Presence(): JSX.Element | null {
  const desk = useRunning((s) => s.desk);
  const elsewhere = isHeldElsewhere(desk);
  if (!elsewhere && desk.connections < 2) return null;
  const own = desk.viewers.filter((each) => each.page === PAGE);
  const others = desk.viewers.filter((each) => each.page !== PAGE);
  // Who holds control is always among those that are shown.
  others.sort((a, b) => Number(b.page === desk.holder) - Number(a.page === desk.holder));
  const shown = [...own, ...others].slice(0, SHOWN);
  const more = [...own, ...others].slice(SHOWN);
  return (
    <div className="presence">
      <ul className="plain" aria-label="Who looks on">
        {shown.map((each) => (
          <li key={each.page}>
            <Chip each={each} holds={each.page === desk.holder} />
          </li>
        ))}
        {more.length > 0 && (
          <li className="presence-more" title={more.map((each) => each.name).join(", ")}>
            +{more.length}
            <span className="hidden"> more: {more.map((each) => each.name).join(", ")}</span>
          </li>
        )}
      </ul>
      <span className="lease" role="group" aria-label="Control">
        <span>{holderText(desk)}</span>
        {elsewhere && <button onClick={() => void takeOver()}>Take over</button>}
        {!elsewhere && desk.holder !== null && <button onClick={() => void giveBack()}>Give back</button>}
      </span>
    </div>
  );
}

function Chip({ each, holds }: { each: Viewer; holds: boolean }): JSX.Element {
  const own = each.page === PAGE;
  const place = each.task ? `looks at ${each.task}` : "looks at the project's files";
  const words = `${each.name}${own ? " (you)" : ""}${holds ? ", controls" : ""}`;
  const dot = (
    <span className={`viewer-dot viewer-${each.colour}`} data-holds={holds} aria-hidden="true">
      {initials(each.name)}
    </span>
  );
  if (!own)
    return (
      <span className="viewer" title={`${words}; ${place}`}>
        {dot}
        <span className="hidden">
          {words}; {place}
        </span>
      </span>
    );
  return (
    <button className="viewer" title={`${words}. Press to change your name`} onClick={() => void askForName()}>
      {dot}
      <span className="hidden">{words}. Change your name</span>
    </button>
  );
}

/** More are counted, and named in the tip. */
const DOTS_SHOWN = 3;

/** Around a node of the canvas. */
export function OthersRing({ path, folded }: { path: string; folded: boolean }): JSX.Element | null {
  const others = useOthersAt(path, folded);
  if (others.length === 0) return null;
  return (
    <span className={`others-ring viewer-ring-${others[0]?.colour}`}>
      <OtherDots others={others} />
      <span className="hidden">{selectedBy(others)}</span>
    </span>
  );
}

/** Initials beside each other, without words for those who hear the page: what they stand at says it. */
export function OtherDots({ others }: { others: readonly Viewer[] }): JSX.Element | null {
  if (others.length === 0) return null;
  return (
    <span className="other-dots" title={selectedBy(others)} aria-hidden="true">
      {others.slice(0, DOTS_SHOWN).map((each) => (
        <span key={each.page} className={`other-dot viewer-${each.colour}`}>
          {initials(each.name)}
        </span>
      ))}
      {others.length > DOTS_SHOWN && <span className="other-dot more">+{others.length - SHOWN}</span>}
    </span>
  );
}
