"""What a maker function returns."""

from dataclasses import dataclass

from mesh import Mesh, grounded
from prints import Atlas


@dataclass
class Item:
    """One object: closed painted grounded parts that share an atlas; its shine (MTL Ks, Ns)."""

    atlas: Atlas
    parts: list[Mesh]
    specular: float
    shininess: float


def item(atlas, parts, specular=0.1, shininess=20):
    return Item(atlas, grounded(parts), specular, shininess)
