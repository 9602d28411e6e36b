"""Actors made from a frozen or copied base: AdaptNet and the paper's alternatives."""

from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.adaptation.adapted import AdaptedActor, Penalties
from sb3_adaptnet.modules.adaptation.adaptors import FullAdaptor
from sb3_adaptnet.modules.adaptation.anchored import AnchoredActor
from sb3_adaptnet.modules.adaptation.injector import Injector
from sb3_adaptnet.modules.adaptation.lora import LowRankAdaptor
from sb3_adaptnet.modules.adaptation.progressive import ProgressiveActor

__all__ = [
    "Adaptation",
    "AdaptedActor",
    "AnchoredActor",
    "FullAdaptor",
    "Injector",
    "LowRankAdaptor",
    "Penalties",
    "ProgressiveActor",
]
