"""Further adaptations that a policy reads beside the one that it trains: checked, filled and frozen."""

from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.architecture import AdaptationShape, Architecture
from sb3_adaptnet.weights.checkpoint import AdaptationFile, build_checked, check_base, load_checked


def frozen(
    read: AdaptationFile, base_name: str, base_hash: str, architecture: Architecture, reads_heightmap: bool
) -> Adaptation:
    """The adaptation in a file.

    Args:
        read: the file.
        base_name: the base that it must adapt.
        base_hash: hash of that base's weights.
        architecture: sizes of that base.
        reads_heightmap: whether observations hold a heightmap.

    Raises:
        CheckpointError: if it adapts another base, or is damaged.
        ValueError: if it reads a heightmap and there is none.
    """
    check_base(read, base_name, base_hash)
    shape = build_checked(read.file, read.card, lambda: AdaptationShape.from_dict(read.card["shape"]))
    if shape.heightmap and not reads_heightmap:
        raise ValueError(f"the adaptation in {str(read.file)!r} reads a heightmap, but the observation space has none")
    adaptation = Adaptation(architecture, shape)
    load_checked(adaptation, read.tensors, read.file)
    return adaptation.requires_grad_(False)
