"""Acts: values that say what to do. `hawk.ddc.performer` performs them; their outcomes are facts of the next tick."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.comm.protocol.commands import CheckFence, Outgoing
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.fence.plan import FencePlan, Standpoint
from hawk.ddc.motion import Goal
from hawk.ddc.orders import Transition
from hawk.model.operation import Fall, Level, StateName, UserError
from hawk.model.plans import DesiredPose, Fence, HeightParameters, Outline
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode

# -- requests: acts that are answered ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SetArmed:
    """Arm or disarm."""

    armed: bool


@dataclass(frozen=True, slots=True)
class SetMode:
    """Change the flight mode."""

    mode: CopterMode


@dataclass(frozen=True, slots=True)
class SendMode:
    """Send a flight mode as a message, once, without an answer: the autopilot is not heard."""

    mode: CopterMode


@dataclass(frozen=True, slots=True)
class TakeOff:
    """Climb to a height, metres above the arm place."""

    height: float


@dataclass(frozen=True, slots=True)
class SetReturnAltitude:
    """Set the autopilot's return altitude, metres above the arm place, and read it back."""

    altitude: float


@dataclass(frozen=True, slots=True)
class UploadFence:
    """Upload the autopilot's fence, enable it and read it back."""

    fence: Fence


@dataclass(frozen=True, slots=True)
class CompareFence:
    """Read the autopilot's fence and compare it with this one; nothing is changed."""

    fence: Fence


@dataclass(frozen=True, slots=True)
class SetHome:
    """Set the autopilot's home, WGS-84; HOME_POSITION is the answer."""

    place: GlobalPose


@dataclass(frozen=True, slots=True)
class CutMotors:
    """Flight termination."""


@dataclass(frozen=True, slots=True)
class ReadParameter:
    """Read one parameter of the autopilot."""

    parameter: str


@dataclass(frozen=True, slots=True)
class SetParameters:
    """Set parameters of the autopilot one by one, each read back."""

    values: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class PutBack:
    """Set one parameter of the autopilot in flight, read back: somebody changed it."""

    parameter: str
    value: float


@dataclass(frozen=True, slots=True)
class EnableFence:
    """Switch the autopilot's fence on by command: a switch or a command turned it off."""


@dataclass(frozen=True, slots=True)
class StoreHeights:
    """Write the parameter file."""

    heights: HeightParameters


@dataclass(frozen=True, slots=True)
class StoreFence:
    """Write the fence file, then plan with it; None drops the drawn fence."""

    plan: FencePlan | None


Request = (
    SetArmed
    | SetMode
    | SendMode
    | TakeOff
    | SetReturnAltitude
    | UploadFence
    | CompareFence
    | SetHome
    | CutMotors
    | ReadParameter
    | SetParameters
    | PutBack
    | EnableFence
    | StoreHeights
    | StoreFence
)


@dataclass(frozen=True, slots=True)
class Ask:
    """Start a request at the time ``at`` (seconds). The same request of the same time is started once."""

    request: Request
    at: float

    @property
    def name(self) -> str:
        """Name for logs; with ``at`` it identifies the request among the facts."""
        match self.request:
            case SetArmed(armed):
                return "arm" if armed else "disarm"
            case SetMode(mode):
                return f"mode {mode.name}"
            case SendMode(mode):
                return f"send {mode.name}"
            case ReadParameter(parameter):
                return f"read {parameter}"
            case PutBack(parameter, _):
                return f"put back {parameter}"
            case other:
                return _NAMES[type(other)]

    @property
    def limit_s(self) -> float:
        """Real seconds within which the request ends, whatever it waits for: the sum of its steps, and some more."""
        match self.request:
            case SetParameters(values):
                return _PARAMETER_S * max(1, len(values))
            case other:
                return _LIMITS_S.get(type(other), _REQUEST_S)

    def answer(self, facts: Facts) -> Answer:
        """Return the outcome of this request so far."""
        return facts.answer(self.name, self.at)


_NAMES: dict[type[object], str] = {
    TakeOff: "take off",
    SetReturnAltitude: "set return altitude",
    UploadFence: "upload fence",
    CompareFence: "compare fence",
    SetHome: "set home",
    CutMotors: "kill",
    SetParameters: "set failsafes",
    EnableFence: "enable fence",
    StoreHeights: "store heights",
    StoreFence: "store fence",
}

_REQUEST_S = 4.0
"""One call into MAVSDK (3 s), and the autopilot's words on a refusal."""
_PARAMETER_S = 12.0
"""The type is read (2 s), the value set until it holds (4 s) and read again until it holds (5 s)."""
_LIMITS_S: dict[type[object], float] = {
    ReadParameter: 6.0,
    SetReturnAltitude: 12.0,
    PutBack: _PARAMETER_S,
    CompareFence: 28.0,  # the polygon 15 s, two parameters 6 s each
    UploadFence: 45.0,  # the polygon 15 s, five parameters 6 s each
    StoreHeights: 5.0,
    StoreFence: 5.0,
}

# -- acts without an answer -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SendTarget:
    """Send one position target through the gate of the service interface."""

    goal: Goal


@dataclass(frozen=True, slots=True)
class Log:
    """Add an entry to the flight log."""

    level: Level
    text: str
    details: str = ""


@dataclass(frozen=True, slots=True)
class ShowUserError:
    """Show a User Error until the next accepted command."""

    error: UserError
    text: str = ""


@dataclass(frozen=True, slots=True)
class Reply:
    """Answer a client whose command waited."""

    client: ClientId
    message: Outgoing


@dataclass(frozen=True, slots=True)
class JudgeFence:
    """Answer a client's Check Fence, by the heights and the drone's place of this moment."""

    client: ClientId
    command: CheckFence
    heights: HeightParameters
    standpoint: Standpoint


@dataclass(frozen=True, slots=True)
class Desire:
    """Publish the desired pose for the planner to judge; None: nothing is desired."""

    pose: DesiredPose | None


@dataclass(frozen=True, slots=True)
class AskPlace:
    """Publish the place of a Route Request; None: nothing is asked."""

    pose: DesiredPose | None


@dataclass(frozen=True, slots=True)
class UseHeights:
    """Put travel heights in force."""

    heights: HeightParameters


@dataclass(frozen=True, slots=True)
class UseOutline:
    """Survey this outline from the next Explore on, and journal it; None: find the lot by looking."""

    outline: Outline | None


@dataclass(frozen=True, slots=True)
class EndLots:
    """Note that a round has looked at these lots, by their ids: they are stored, and not flown to again."""

    lots: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TakePlan:
    """Fly with this changed plan of the lot, the id of an offer, from now on."""

    plan: str


@dataclass(frozen=True, slots=True)
class SetDatum:
    """Set the origin of the map frame."""

    datum: GlobalPose


@dataclass(frozen=True, slots=True)
class PutFenceInForce:
    """Guard this fence from now on."""

    fence: Fence


@dataclass(frozen=True, slots=True)
class BeginSurvey:
    """Begin another survey with an empty map and no datum."""


@dataclass(frozen=True, slots=True)
class ForgetAskedModes:
    """No mode change is ours until a mode is asked for again."""


@dataclass(frozen=True, slots=True)
class SettleMode:
    """The autopilot's mode became this one: of the modes that were asked for, those of before are not ours any more."""

    mode: int


@dataclass(frozen=True, slots=True)
class ForgetHeldFence:
    """The autopilot was not heard for a while: the fence that it holds is not known until it is read again."""


@dataclass(frozen=True, slots=True)
class SetVoice:
    """Let our heartbeats go out, or hold them back."""

    speaks: bool


@dataclass(frozen=True, slots=True)
class CountStart:
    """Journal a start in the air; the count is a fact of the next tick. Restore flight time and path."""


@dataclass(frozen=True, slots=True)
class KeepFall:
    """Journal that the motors went off in the air; None: the operator cleared it."""

    fall: Fall | None


@dataclass(frozen=True, slots=True)
class EnterState:
    """Another state is the active one, or may send other targets now: publish it, and let the gate know."""

    name: StateName
    may_send_targets: bool
    holds: bool


@dataclass(frozen=True, slots=True)
class Record:
    """Record a decision."""

    kind: str
    payload: tuple[tuple[str, str | float | None], ...]


Act = (
    Ask
    | SendTarget
    | Log
    | ShowUserError
    | Reply
    | JudgeFence
    | Desire
    | AskPlace
    | UseHeights
    | UseOutline
    | EndLots
    | TakePlan
    | SetDatum
    | BeginSurvey
    | PutFenceInForce
    | ForgetAskedModes
    | SettleMode
    | ForgetHeldFence
    | SetVoice
    | CountStart
    | KeepFall
    | EnterState
    | Record
)
Acts = tuple[Act, ...]


@dataclass(frozen=True, slots=True)
class Step:
    """Outcome of a decision: acts, then a transition (None: the state stays).

    ``restarts``: the state begins its work again from where the drone is.
    """

    transition: Transition | None = None
    acts: Acts = ()
    restarts: bool = False


STAY = Step()
"""Nothing to do."""
