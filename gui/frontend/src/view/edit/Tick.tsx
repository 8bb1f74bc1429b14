/** A box to tick whose state is the server's: it shows what was wished until the answer is there. */
import { type JSX, useEffect, useRef, useState } from "react";

interface Props {
  readonly label: string;
  readonly checked: boolean;
  readonly disabled?: boolean;
  readonly set: (checked: boolean) => Promise<unknown>;
}

export function Tick({ label, checked, disabled = false, set }: Props): JSX.Element {
  const [shown, setShown] = useState(checked);
  const now = useRef(checked);
  useEffect(() => {
    now.current = checked;
    setShown(checked);
  }, [checked]);
  const change = async (wished: boolean): Promise<void> => {
    setShown(wished);
    await set(wished);
    setShown(now.current);
  };
  return (
    <label className="check">
      <input type="checkbox" checked={shown} disabled={disabled} onChange={(event) => void change(event.target.checked)} />
      {label}
    </label>
  );
}
