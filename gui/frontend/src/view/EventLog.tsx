/** The journal as text: the latest events up to the shown moment. */
import { type JSX, useEffect, useRef } from "react";

import { eventText, seconds } from "../model/words";
import { usePage } from "../store/page";
import { useRun } from "../store/run";

/** Most lines that are shown; the time line reaches the others. */
const SHOWN = 300;

export function EventLog(): JSX.Element {
  useRun((s) => s.version);
  const { history, cursor } = useRun.getState();
  const { select } = usePage.getState();
  const count = cursor ?? history.length;
  const first = Math.max(0, count - SHOWN);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (box.current) box.current.scrollTop = box.current.scrollHeight;
  }, [count]);
  return (
    <section className="panel log" aria-labelledby="log-title">
      <h2 id="log-title">Events</h2>
      <div className="scroll" ref={box} tabIndex={0} role="group" aria-labelledby="log-title">
        {first > 0 && <p className="hint padded">{first} earlier events are on the time line.</p>}
        <ol>
          {history.events.slice(first, count).map((event) => (
            <li key={event.seq} className={`event-${event.event}`} onClick={() => select(event.path)}>
              <span className="event-time">{seconds(event.t)}</span>
              <span className="event-path">{event.path}</span>
              <span className="event-text">{eventText(event)}</span>
            </li>
          ))}
        </ol>
      </div>
    </section>
  );
}
