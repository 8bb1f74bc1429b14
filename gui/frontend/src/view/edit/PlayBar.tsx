/** While a counterexample is played: which form is shown, and the way back to the decision. */
import type { JSX } from "react";

import { SIDES, showPlay, type Side, sideOf, usePlays } from "../../store/plays";
import { useRun } from "../../store/run";

const SHORT: Record<Side, string> = { now: "Now", then: "Then" };

export function PlayBar(): JSX.Element | null {
  const side = useRun((s) => sideOf(s.record));
  const decide = usePlays((s) => s.decide);
  if (side === null) return null;
  return (
    <>
      <span className="hint">Counterexample</span>
      <div className="segments" role="group" aria-label="Form that is played">
        {SIDES.map(([name, label]) => (
          <button key={name} title={label} aria-pressed={side === name} onClick={() => showPlay(name)}>
            {SHORT[name]}
          </button>
        ))}
      </div>
      <button onClick={decide}>Decide</button>
    </>
  );
}
