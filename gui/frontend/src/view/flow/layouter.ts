/** Lays charts out beside the page: ELK in a worker, which is loaded with the flow chart. */
import ELK from "elkjs/lib/elk-api.js";
import workerUrl from "elkjs/lib/elk-worker.min.js?url";
import { useEffect, useRef, useState } from "react";

import { chartOf, type FlowChart, remembering, type Scene } from "../../model/flowChart";
import type { Lay } from "../../model/flowElk";
import type { Pins } from "../../model/flowPins";
import { useRun } from "../../store/run";

/** A layout that nobody waits for any more is ended when it has taken so long [ms]; beginning again costs about 300. */
const LONG = 500;

class Layouter {
  private elk: InstanceType<typeof ELK> | null = null;
  private lay: Lay = this.fresh();
  private since = 0;
  private under_way = 0;

  private fresh(): Lay {
    return remembering(async (graph) => {
      this.elk ??= new ELK({ workerUrl });
      if (this.under_way++ === 0) this.since = performance.now();
      try {
        return await this.elk.layout(graph);
      } finally {
        this.under_way--;
      }
    });
  }

  chart(scene: Scene, pins: Pins): Promise<FlowChart> {
    if (this.under_way > 0 && performance.now() - this.since > LONG) {
      this.elk?.terminateWorker();
      this.elk = null;
      this.under_way = 0;
      this.lay = this.fresh();
    }
    return chartOf(scene, pins, this.lay);
  }
}

const layouter = new Layouter();

export interface Shown {
  /** Of which container. */
  readonly key: string;
  readonly chart: FlowChart;
  readonly scene: Scene;
}

/** The newest chart that is laid out: until a newer one is, the one before stays. */
export function useChart(scene: Scene, pins: Pins, key: string): Shown | null {
  const [shown, setShown] = useState<Shown | null>(null);
  const newest = useRef(0);
  useEffect(() => {
    const mine = ++newest.current;
    layouter.chart(scene, pins).then(
      (chart) => mine === newest.current && setShown({ key, chart, scene }),
      (error: unknown) => mine === newest.current && useRun.getState().setError(`The flow chart can't be laid out: ${error instanceof Error ? error.message : JSON.stringify(error)}`),
    );
  }, [scene, pins, key]);
  return shown;
}
