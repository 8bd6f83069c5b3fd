"""Since when a pad presses, by its pressing force alone."""

from brake_monitor.estimation.inputs.pad_contact import RECOVERY_S, RELEASE_FRACTION, PadContact

THRESHOLD_N = 2000.0
JUST_BELOW_N = 0.5 * (1.0 + RELEASE_FRACTION) * THRESHOLD_N


def test_a_force_about_the_threshold_does_not_flicker() -> None:
    contact = PadContact(THRESHOLD_N)
    assert not contact.see(0.0, JUST_BELOW_N)
    assert contact.see(0.1, THRESHOLD_N)
    assert not contact.see(0.2, JUST_BELOW_N)
    assert contact.pressed
    assert contact.see(0.3, 0.5 * RELEASE_FRACTION * THRESHOLD_N)
    assert not contact.pressed


def test_friction_shows_a_while_after_contact_also_by_a_clock_that_is_set_back() -> None:
    contact = PadContact(THRESHOLD_N)
    contact.see(100.0, THRESHOLD_N)
    assert not contact.is_settled(100.0 + 0.9 * RECOVERY_S)
    assert contact.is_settled(100.0 + 1.1 * RECOVERY_S)
    contact.restart(40.0)
    assert contact.is_settled(40.0 + 1.1 * RECOVERY_S)
