"""The shipped example of a secured fleet, as it is written: who hears, who is heard, and who may acknowledge."""

import json
import logging
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
import zenoh
from zenoh import ext

from brake_monitor.errors import InputError
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.about import about
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.publishing.zenoh_session import session_config
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.zenoh_settings import TlsSettings, ZenohSettings
from estimates import alarm, estimate
from network import free_port
from program import PATIENCE_S, until
from secured_fleet import EXAMPLES, Fleet

WAGON = "brake/v1/wagon-8127"

pytestmark = pytest.mark.skipif(not shutil.which("openssl"), reason="needs openssl: apt-get install openssl")


def answers(opened: zenoh.Session, key: str, **more: Any) -> dict[str, Any]:
    replies = [reply.ok for reply in opened.get(key, timeout=PATIENCE_S, **more) if reply.ok]
    return {str(reply.key_expr): json.loads(reply.payload.to_bytes()) for reply in replies}


def test_a_dashboard_hears_asks_and_is_told_who_lives(fleet: Fleet) -> None:
    heard: dict[str, int] = {}
    with fleet.session("dashboard") as dashboard:

        def note(sample: zenoh.Sample) -> None:
            heard[str(sample.key_expr)] = heard.get(str(sample.key_expr), 0) + 1

        with (
            dashboard.declare_subscriber(f"{WAGON}/adhesion", note),
            ext.declare_advanced_subscriber(
                dashboard, "brake/v1/*/alarm/**", note, history=ext.HistoryConfig(detect_late_publishers=True)
            ),
            dashboard.liveliness().declare_subscriber("brake/v1/*", note, history=True),
        ):
            fleet.publisher.publish(Outputs(None, (alarm(),)))
            until(lambda: fleet.publisher.publish(Outputs(estimate())) or len(heard) == 3)
        assert heard.keys() == {f"{WAGON}/adhesion", f"{WAGON}/alarm/low_adhesion", WAGON}
        assert (heard[f"{WAGON}/alarm/low_adhesion"], heard[WAGON]) == (1, 1)
        assert answers(dashboard, f"{WAGON}/**").keys() >= {f"{WAGON}/adhesion", f"{WAGON}/alarm/low_adhesion"}


def test_who_has_no_certificate_or_a_strangers_is_not_let_in(fleet: Fleet) -> None:
    nobody = fleet.config("dashboard")
    for name in ("connect_certificate", "connect_private_key"):
        nobody.insert_json5(f"transport/link/tls/{name}", "null")
    nobody.insert_json5("transport/link/tls/enable_mtls", "false")
    for config in (nobody, fleet.config("dashboard", authority="stranger")):
        with pytest.raises(zenoh.ZError):
            zenoh.open(config).close()
    with fleet.session("dashboard") as dashboard:  # the router does let in whom it should
        until(lambda: answers(dashboard, f"{WAGON}/meta"))


def test_a_valid_certificate_without_rights_hears_and_gets_nothing(fleet: Fleet) -> None:
    heard: list[str] = []
    with fleet.session("unknown") as unknown, fleet.session("dashboard") as dashboard:
        proof: list[str] = []
        with (
            unknown.declare_subscriber("brake/**", lambda sample: heard.append(str(sample.key_expr))),
            dashboard.declare_subscriber("brake/v1/**", lambda sample: proof.append(str(sample.key_expr))),
        ):
            until(lambda: fleet.publisher.publish(Outputs(estimate())) or len(proof) > 20)
            assert answers(unknown, f"{WAGON}/**") == {}
    assert heard == []


@pytest.mark.parametrize("name", ["dashboard", "workshop", "unknown"])
def test_nobody_but_the_wagon_is_heard_in_its_name(fleet: Fleet, name: str) -> None:
    forged: list[bytes] = []
    with fleet.session("dashboard") as listener, fleet.session(name) as forger:
        proof: list[str] = []

        def note(sample: zenoh.Sample) -> None:
            (forged if b"forged" in sample.payload.to_bytes() else proof).append(sample.payload.to_bytes())

        with listener.declare_subscriber("brake/v1/**", note):
            until(lambda: fleet.publisher.publish(Outputs(estimate())) or proof)
            fleet.publisher.publish(Outputs(None, (alarm(),)))
            for _ in range(20):
                forger.put(f"{WAGON}/alarm/low_adhesion", b'{"forged": true}')
                forger.delete(f"{WAGON}/alarm/low_adhesion")
                forger.put(f"{WAGON}/acknowledge", b'{"id": "forged"}')
            before = len(proof)
            until(lambda: fleet.publisher.publish(Outputs(estimate())) or len(proof) > before + 5)
        kept = answers(listener, f"{WAGON}/alarm/**")
    assert forged == []
    assert kept[f"{WAGON}/alarm/low_adhesion"]["state"] == "open"


def test_only_the_workshop_acknowledges(fleet: Fleet) -> None:
    fleet.publisher.publish(Outputs(None, (alarm(id="one"),)))
    until(lambda: fleet.publisher.counters.events_sent)
    with fleet.session("dashboard") as dashboard, fleet.session("workshop") as workshop:
        until(lambda: answers(dashboard, f"{WAGON}/meta"))
        for key in (f"{WAGON}/acknowledge", "brake/v1/*/acknowledge", "brake/v1/*/acknowledg$*", f"{WAGON}/**"):
            assert f"{WAGON}/acknowledge" not in answers(dashboard, key, payload=b'{"id": "one"}')
        assert fleet.publisher.acknowledged() == []
        until(lambda: answers(workshop, f"{WAGON}/acknowledge", payload=b'{"id": "one"}'))
    assert "one" in fleet.publisher.acknowledged()


def test_hosts_are_names_or_addresses_and_a_wagon_may_be_called_by_a_number(tmp_path: Path) -> None:
    names = ("router=::1", "depot=192.0.2.1", "338012345678")
    subprocess.run([EXAMPLES / "make-certificates", tmp_path, *names], check=True, timeout=60)
    for name, host in (("router", "IP Address:0:0:0:0:0:0:0:1"), ("depot", "IP Address:192.0.2.1"), (names[2],) * 2):
        said = subprocess.run(
            ["openssl", "x509", "-in", tmp_path / f"{name}.pem", "-noout", "-ext", "subjectAltName"],
            capture_output=True,
            text=True,
            check=True,
        )
        assert said.stdout.strip().endswith(host)


def test_certificates_that_are_missing_are_made_and_no_others(tmp_path: Path) -> None:
    script = (EXAMPLES / "make-certificates", tmp_path, "wagon-8127")
    subprocess.run(script, check=True, timeout=60)
    certificate, key = ((tmp_path / f"wagon-8127.{suffix}") for suffix in ("pem", "key"))
    made = certificate.read_text(), key.read_text()
    subprocess.run(script, check=True, timeout=60)
    assert (certificate.read_text(), key.read_text()) == made
    certificate.unlink()
    subprocess.run(script, check=True, timeout=60)
    assert certificate.exists()
    assert key.read_text() == made[1]


def test_secrets_are_neither_logged_nor_published(pki: Path, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    tls = TlsSettings(pki / "pki" / "ca.pem", pki / "pki" / "wagon-8127.pem", pki / "pki" / "wagon-8127.key")
    listening = ZenohSettings(listen=(f"tls/127.0.0.1:{free_port()}",), tls=tls)
    settings = example_settings("wagon")
    with Publisher(listening, "wagon-8127", about=about(settings, 0.0)):
        time.sleep(0.3)
    told = caplog.text + encode(about(settings, 0.0)).decode()
    secret = "".join((pki / "pki" / "wagon-8127.key").read_text().splitlines()[1:-1])
    assert secret[:20] not in told
    assert "wagon-8127.key" not in told


def test_what_is_not_encrypted_is_refused_where_certificates_are_configured(pki: Path) -> None:
    tls = TlsSettings(pki / "pki" / "ca.pem", pki / "pki" / "wagon-8127.pem", pki / "pki" / "wagon-8127.key")
    with pytest.raises(InputError, match=r"\[zenoh\] connect 'tcp/127.0.0.1:1': with \[zenoh.tls\] expected tls/"):
        session_config(ZenohSettings(connect=("tcp/127.0.0.1:1",), listen=(), tls=tls))
    missing = TlsSettings(pki / "none.pem", tls.certificate, tls.private_key)
    with pytest.raises(InputError, match=r"\[zenoh.tls\] root_ca: .*none.pem cannot be read: No such file"):
        session_config(ZenohSettings(listen=(), tls=missing))
