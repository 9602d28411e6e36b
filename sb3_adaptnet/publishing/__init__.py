"""Weights ready for the Hub: a folder with weights, cards, picture and film, and its upload."""

from sb3_adaptnet.publishing.folder import Publication, publishable_card, write_folder
from sb3_adaptnet.publishing.model_card import model_card
from sb3_adaptnet.publishing.upload import upload

__all__ = ["Publication", "model_card", "publishable_card", "upload", "write_folder"]
