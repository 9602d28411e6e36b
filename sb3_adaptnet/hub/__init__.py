"""The Hugging Face Hub: addresses of weights on it, and how they get into its local cache."""

from sb3_adaptnet.hub.address import HubAddress, is_address, parse_address
from sb3_adaptnet.hub.base_model import base_model_beside
from sb3_adaptnet.hub.download import HubError, download

__all__ = ["HubAddress", "HubError", "base_model_beside", "download", "is_address", "parse_address"]
