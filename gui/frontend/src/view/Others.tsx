/** Where other people are: a ring of their colour with their initials, which take no room, so that nothing moves. */
import type { JSX } from "react";

import { initials, selectedBy } from "../model/others";
import type { Onlooker } from "../protocol/generated";
import { useOthersAt } from "../store/others";

/** More are counted, and named in the tip. */
const SHOWN = 3;

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
export function OtherDots({ others }: { others: readonly Onlooker[] }): JSX.Element | null {
  if (others.length === 0) return null;
  return (
    <span className="other-dots" title={selectedBy(others)} aria-hidden="true">
      {others.slice(0, SHOWN).map((each) => (
        <span key={each.page} className={`other-dot viewer-${each.colour}`}>
          {initials(each.name)}
        </span>
      ))}
      {others.length > SHOWN && <span className="other-dot more">+{others.length - SHOWN}</span>}
    </span>
  );
}
