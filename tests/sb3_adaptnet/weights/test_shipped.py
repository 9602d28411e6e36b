"""Names of shipped files."""

import pytest
from weight_cases import ENV

from sb3_adaptnet import (
    CheckpointError,
    load_policy,
)
from sb3_adaptnet.weights.shipped import pretrained_path, zoo_config_path


def test_unknown_names_list_the_known():
    with pytest.raises(CheckpointError, match="moonwalk"):
        load_policy("moonwalk", ENV)
    with pytest.raises(ValueError, match="moonwalk"):
        pretrained_path("moonwalk")
    with pytest.raises(ValueError, match="moonwalk"):
        zoo_config_path("moonwalk")
