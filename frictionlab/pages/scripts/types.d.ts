// What `nox -s javascript` checks the scripts with: the data of a page, and fields that constructors set together.
declare const SCENE: any, SOLVER: any, STRUCTURES: any, CARDS: any[], mlMatrix: any, MARKUP: string;
interface Assembler { [instruction: string]: any }
interface Axis { low: number; high: number; start: number; stop: number; log: boolean; turns: boolean }
interface BodyDrag { explorer: Explorer; over: HTMLCanvasElement; body: any; mode: number; shown: any }
interface BodyDrag { now: Record<string, number> }
interface BrowserEngine { solver: Solver }
interface Explorer {
  root: HTMLElement; scene: any; engine: any; options: { address?: boolean }; audio: AudioContext | undefined;
  [part: string]: any;
}
interface Lesson { explorer: Explorer; node: HTMLElement; steps: any[]; recording: boolean }
interface ModeWriter {
  J: any; code: any; column: any; constants: any; first: any; flow: any; inputs: any; k: any; kNumber: any; last: any;
  leastRatio: any; ops: any; order: any; row: any; share: any; slots: any; terms: any; total: any; values: any; z: any;
}
interface StateHistory { place: number; since: number }
interface SvgContext { fillStyle: string; font: string; lineWidth: number; strokeStyle: string; textAlign: string }
