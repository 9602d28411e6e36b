"""What an exported graph says about itself: enough to run it in any simulator."""

import json
import math
from collections.abc import Mapping
from typing import Any

from adapt_envs.model import CONTROL_DT, PHYSICS_STEPS, compile_model
from sb3_adaptnet.exporting.adaptations import Exported
from sb3_adaptnet.modules.architecture import OBSERVATION_VERSION


def metadata_of(exported: Exported, strengths: Mapping[str, float]) -> dict[str, str]:
    """JSON values by name, as an ONNX file's metadata.

    `base` and `base_hash`; `adaptations` in the order of the strengths and `default_strengths`; `joints` in the order
    of the actions and `servos`, their gains; `control_hz`, `physics_hz`; `observation_version`, `reads_heightmap`.

    Raises:
        ValueError: for a default strength that is not finite.
    """
    for name, strength in strengths.items():
        if not math.isfinite(strength):
            raise ValueError(f"the strength of {name!r} must be a finite number, not {strength}")
    joints = exported.base.backbone.architecture.joints
    values = {
        "base": exported.base.name,
        "base_hash": exported.base.hash,
        "adaptations": list(exported.adaptations),
        "default_strengths": [float(strengths[name]) for name in exported.adaptations],
        "joints": list(joints),
        "servos": servos(joints),
        "control_hz": round(1 / CONTROL_DT),
        "physics_hz": round(PHYSICS_STEPS / CONTROL_DT),
        "observation_version": OBSERVATION_VERSION,
        "reads_heightmap": exported.reads_heightmap,
    }
    return {name: json.dumps(value) for name, value in values.items()}


def servos(joints: tuple[str, ...]) -> list[dict[str, Any]]:
    """Gains of the joints' servos: torque = kp (middle + action x range - angle) - kd rate.

    Returns:
        For each joint its name, `kp` [N m/rad], `kd` [N m s/rad], `middle` and `range` [rad].
    """
    model = compile_model()
    rows = []
    for name in joints:
        servo = model.actuator(name)
        kp, kd = -float(servo.biasprm[1]), -float(servo.biasprm[2])
        middle, width = float(servo.biasprm[0]) / kp, float(servo.gainprm[0]) / kp
        rows.append({"joint": name, "kp": kp, "kd": kd, "middle": middle, "range": width})
    return rows
