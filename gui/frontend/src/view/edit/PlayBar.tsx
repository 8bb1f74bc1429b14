/** While a counterexample is played: which form is shown, and the way back to the decision. */
import type { JSX } from "react";

import { SIDES, showPlay, sideOf, usePlays } from "../../store/plays";
import { useRun } from "../../store/run";

export function PlayBar(): JSX.Element | null {
  const side = useRun((s) => sideOf(s.record));
  const decide = usePlays((s) => s.decide);
  if (side === null) return null;
  return (
    <>
      <span className="hint">Counterexample</span>
      <div className="segments" role="group" aria-label="Form that is played">
        {SIDES.map(([name, label]) => (
          <button key={name} aria-pressed={side === name} onClick={() => showPlay(name)}>
            {label}
          </button>
        ))}
      </div>
      <button onClick={decide}>Decide</button>
    </>
  );
}
