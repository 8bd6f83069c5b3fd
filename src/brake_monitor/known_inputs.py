"""What acts on the wagon and is told rather than estimated: forces, torques, load, gradient; sand, WSP and place."""

from collections.abc import Collection, Sequence

from brake_monitor.brake_step import PadForces
from brake_monitor.held_input import HeldInput
from brake_monitor.pad_contact import PadContact
from brake_monitor.plausibility import SpikeGate
from brake_monitor.regime import Terms
from brake_monitor.samples import Quantity, Sample
from brake_monitor.wagon import GRAVITY_MPS2, Inputs, Wagon

LONGEST_STEP_S = 1.0  # a longer gap between readings says nothing of what happened in it
LOADED = 0.05  # relative; who weighs so much more or less was loaded or unloaded
LOAD_READINGS = 50  # whose mean counts: a mass that flickers shakes the wheel loads, see `load_transfer`
LARGEST_LOAD_RATIO = 8.0  # a wagon's weight over the configured one, or the other way round


class KnownInputs:
    """The inputs of one wagon. They act from their own time on, so that taking one needs no prediction."""

    def __init__(self, wagon: Wagon, channels: Collection[tuple[Quantity, int]], contact_force_n: float) -> None:
        """`channels` says which quantities are mapped, and for which wheelsets."""
        self._wheels = wheels = range(wagon.layout.wheelset_count)
        self._configured_kg = wagon.mass_kg
        self._load_signals = sum(quantity is Quantity.LOAD_FORCE for quantity, _ in channels)
        self.one_wsp_signal = (Quantity.WSP_ACTIVE, 1) not in channels
        self._gate = [SpikeGate() for _ in wheels]
        self._force = [HeldInput() for _ in wheels]
        self._torque = [HeldInput() for _ in wheels]
        self._torque_is_known = [True for _ in wheels]  # False: it was lost while it acted
        self._contact = [PadContact(contact_force_n) for _ in wheels]
        self._followed_n = [0.0 for _ in wheels]  # pressing forces that mu_w has followed so far
        self._load_n: dict[int, float] = {}
        self._weighed = 0  # readings in the mean of the mass
        self.u = wagon.inputs()  # of the step taken last: (14)
        self.wsp = [False for _ in wheels]
        self.sanding = False
        self.place_deg: dict[Quantity, float] = {}

    def take(self, sample: Sample) -> bool:
        """Take a sample that is no measurement of the state; True when it told a pressing force to be believed."""
        i, value = sample.wheelset, sample.value
        match sample.quantity:
            case Quantity.PRESSING_FORCE:
                return self._take_force(i, sample.time_s, max(value, 0.0))
            case Quantity.WHEEL_TORQUE:
                self._torque[i].sample(sample.time_s, value, LONGEST_STEP_S)
                self._torque_is_known[i] = True
            case Quantity.WSP_ACTIVE:
                for wheel in self._told_of(i):
                    self.wsp[wheel] = value != 0.0
            case Quantity.SANDING:
                self.sanding = value != 0.0
            case Quantity.LATITUDE | Quantity.LONGITUDE:
                self.place_deg[sample.quantity] = value
            case Quantity.GRADIENT:
                self.u = self.u._replace(gradient=value)
            case Quantity.LOAD_FORCE:
                self._load_n[i] = value
                if len(self._load_n) == self._load_signals:
                    self._take_mass(sum(self._load_n.values()) / GRAVITY_MPS2)
        return False

    def lose(self, sample: Sample) -> None:
        """Nothing is told any more: what was told last is not so for ever. Pressing forces and load are held.

        A brake that holds its air and a wagon that is not loaded on the way stay as they are; without the forces no
        estimate is valid anyway.
        """
        i = sample.wheelset
        match sample.quantity:
            case Quantity.WHEEL_TORQUE:
                self._torque_is_known[i] &= self._torque[i].value == 0.0
                self._torque[i].sample(sample.time_s, 0.0, longest_gap_s=0.0)
            case Quantity.WSP_ACTIVE:
                self.let_go_flag(i)
            case Quantity.SANDING:
                self.sanding = False
            case Quantity.LATITUDE | Quantity.LONGITUDE:
                self.place_deg.pop(sample.quantity, None)
            case Quantity.GRADIENT:
                self.u = self.u._replace(gradient=0.0)

    def let_go_flag(self, i: int) -> None:
        """Nothing acts, for all that the WSP signal at place i tells."""
        for wheel in self._told_of(i):
            self.wsp[wheel] = False

    def _told_of(self, i: int) -> Collection[int]:
        """The wheelsets that the WSP signal at place i tells of."""
        return self._wheels if self.one_wsp_signal else (i,)

    def _take_force(self, i: int, time_s: float, pressing_force_n: float) -> bool:
        believed = self._gate[i].pass_on(time_s, pressing_force_n)
        for then_s, force_n in believed:
            self._force[i].sample(then_s, force_n, LONGEST_STEP_S)
            self._contact[i].see(then_s, force_n)
        return bool(believed)

    def _take_mass(self, mass_kg: float) -> None:
        """Take what the load signals say unless the wagon cannot weigh that: a broken sensor says nothing or all."""
        if not self._configured_kg / LARGEST_LOAD_RATIO <= mass_kg <= self._configured_kg * LARGEST_LOAD_RATIO:
            return
        before_kg = self.u.mass_kg
        is_same = abs(mass_kg - before_kg) <= LOADED * before_kg
        self._weighed = min(self._weighed, LOAD_READINGS - 1) + 1 if is_same else 1
        self.u = self.u._replace(mass_kg=before_kg + (mass_kg - before_kg) / self._weighed)

    def advance(self, time_s: float, step_s: float) -> PadForces:
        """Put the means over the step that ends at time_s into `u`; return what the forces did beside them."""
        impulse_std_ns = [force.impulse_std_until(time_s) for force in self._force]
        unseen_std_ns = [force.unseen_std_until(time_s) for force in self._force]
        force_n = [force.mean_until(time_s, step_s) for force in self._force]
        torque_nm = [torque.mean_until(time_s, step_s) for torque in self._torque]
        self.u = Inputs(force_n, torque_nm, *self.u[2:])
        begin_n, self._followed_n = self._followed_n, [force.value for force in self._force]
        return PadForces(begin_n, self._followed_n, impulse_std_ns, unseen_std_ns)

    def take_conditions(self, terms: Terms, wheel_load_n: Sequence[float]) -> None:
        """Of the step that is about to be taken."""
        self.u = Inputs(*self.u[:4], terms.turns, terms.observed, wheel_load_n)

    def follow(self, i: int) -> None:
        """The pressing force is told anew: what mu_w,i did meanwhile, the speeds have told."""
        self._followed_n[i] = self._force[i].value

    def restart(self, time_s: float) -> None:
        """The next step begins at time_s with the values told last."""
        for held in (*self._force, *self._torque):
            held.restart(time_s)
        for contact in self._contact:
            contact.restart(time_s)

    def pressing_force_n(self, i: int) -> float:
        """The pressing force of a wheelset as told last."""
        return self._force[i].value

    @property
    def tells_promptly(self) -> bool:
        """Whether the pressing forces come so often that they show what slide protection does to them."""
        return all(force.is_prompt for force in self._force)

    def is_free(self, i: int) -> bool:
        """Whether no torque from motor or dynamic brake acts on the wheelset."""
        return self._torque_is_known[i] and self._torque[i].value == 0.0

    def torque_is_known(self, i: int) -> bool:
        """Whether the torque of motor or dynamic brake is not one that was lost while it acted."""
        return self._torque_is_known[i]

    def is_pressed(self, i: int) -> bool:
        """Whether the wheelset's pads touch its discs."""
        return self._contact[i].pressed

    @property
    def any_pressed(self) -> bool:
        """Whether any pad of the wagon touches its disc."""
        return any(contact.pressed for contact in self._contact)

    def is_settled(self, i: int, time_s: float) -> bool:
        """Whether the wheelset's pads have pressed long enough to show their friction."""
        return self._contact[i].is_settled(time_s)
