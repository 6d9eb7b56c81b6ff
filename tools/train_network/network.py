"""EfficientNet-Lite0 (Tan and Le 2019; its Lite variant) in JAX, batch normalisation folded.

Images are [batch, height, width, channel], RGB in 0..255. Depthwise convolutions are sums of shifted
products, pointwise ones matrix products: on a CPU both are several times faster than JAX's own
convolution.
"""

import collections
import pickle

import jax
import jax.numpy as jnp
import numpy as np

MEAN = np.array([0.485, 0.456, 0.406], np.float32) * 255
DEVIATION = np.array([0.229, 0.224, 0.225], np.float32) * 255
EPSILON = 1e-3  # of the batch normalisation

Block = collections.namedtuple("Block", "kernel stride expand residual")
# Of each stage: repeats, kernel, stride, whether it expands.
STAGES = [(1, 3, 1, False), (2, 3, 2, True), (2, 5, 2, True), (3, 3, 2, True), (3, 5, 1, True),
          (4, 5, 2, True), (1, 3, 1, True)]
BLOCKS = [Block(kernel, stride if i == 0 else 1, expand, i > 0)
          for repeats, kernel, stride, expand in STAGES for i in range(repeats)]
TUNED_FROM = len(BLOCKS) - 5  # the blocks from here on are trained, those before it are as they were


class _LegacyUnpickler(pickle.Unpickler):
    """Of torch's first file format: storages are named in the pickle and follow it as raw bytes."""

    def find_class(self, module, name):
        if (module, name) == ("collections", "OrderedDict"):
            return collections.OrderedDict
        if name == "_rebuild_tensor_v2":
            return lambda storage, offset, shape, stride, *_: (storage, offset, shape, stride)
        if module == "torch" and name.endswith("Storage"):
            return {"FloatStorage": np.float32, "LongStorage": np.int64}[name]
        raise pickle.UnpicklingError(f"{module}.{name} has no place in a file of weights")

    def persistent_load(self, storage):
        return storage


def read_weights(path):
    """The tensors of a legacy .pth by name."""
    with open(path, "rb") as file:
        for _ in range(3):  # magic number, protocol, the writer's system
            _LegacyUnpickler(file).load()
        tensors = _LegacyUnpickler(file).load()
        types = {storage[2]: storage[1] for storage, *_ in tensors.values()}
        storages = {}
        for key in _LegacyUnpickler(file).load():
            count = int(np.fromfile(file, np.int64, 1)[0])
            storages[key] = np.fromfile(file, types[key], count)
    return {name: np.lib.stride_tricks.as_strided(
                storages[storage[2]][offset:], shape,
                [step * storages[storage[2]].itemsize for step in stride]).copy()
            for name, (storage, offset, shape, stride) in tensors.items()}


def _folded(weights, convolution, normalisation):
    """{w, b} of a convolution with the batch normalisation after it; w is [out, in, k, k]."""
    scale = weights[f"{normalisation}.weight"] / np.sqrt(
        weights[f"{normalisation}.running_var"] + EPSILON)
    return {"w": weights[f"{convolution}.weight"] * scale[:, None, None, None],
            "b": weights[f"{normalisation}.bias"] - weights[f"{normalisation}.running_mean"] * scale}


def pretrained(path):
    """{stem, blocks, head} with folded weights."""
    weights = read_weights(path)
    blocks = []
    for i, block in enumerate(BLOCKS):
        name = f"_blocks.{i}"
        layers = {"depthwise": _folded(weights, f"{name}._depthwise_conv", f"{name}._bn1"),
                  "project": _folded(weights, f"{name}._project_conv", f"{name}._bn2")}
        if block.expand:
            layers["expand"] = _folded(weights, f"{name}._expand_conv", f"{name}._bn0")
        blocks.append(layers)
    return {"stem": _folded(weights, "_conv_stem", "_bn0"), "blocks": blocks,
            "head": _folded(weights, "_conv_head", "_bn1")}


def padding(size, kernel, stride):
    """TensorFlow's "SAME": (before, after)."""
    total = max((-(-size // stride) - 1) * stride + kernel - size, 0)
    return total // 2, total - total // 2


def _windows(x, kernel, stride):
    """Each of the kernel's kernel**2 positions with the pixels that lie under it."""
    rows, columns = (padding(size, kernel, stride) for size in x.shape[1:3])
    x = jnp.pad(x, ((0, 0), rows, columns, (0, 0)))
    height, width = ((size - kernel) // stride + 1 for size in x.shape[1:3])
    for v in range(kernel):
        for u in range(kernel):
            yield v, u, x[:, v:v + (height - 1) * stride + 1:stride,
                          u:u + (width - 1) * stride + 1:stride]


def _relu6(x):
    return jnp.clip(x, 0, 6)


def _pointwise(x, layer):
    return x @ layer["w"][:, :, 0, 0].T + layer["b"]


def _depthwise(x, layer, kernel, stride):
    return sum(window * layer["w"][:, 0, v, u] for v, u, window in _windows(x, kernel, stride)) + \
        layer["b"]


def _run_block(x, layers, block):
    y = _relu6(_pointwise(x, layers["expand"])) if block.expand else x
    y = _relu6(_depthwise(y, layers["depthwise"], block.kernel, block.stride))
    y = _pointwise(y, layers["project"])
    return x + y if block.residual else y


@jax.jit
def trunk(network, images):
    """What the blocks that are not trained make of images."""
    x = (images - MEAN) / DEVIATION
    stem = network["stem"]
    x = _relu6(sum(window @ stem["w"][:, :, v, u].T for v, u, window in _windows(x, 3, 2)) +
               stem["b"])
    for layers, block in zip(network["blocks"][:TUNED_FROM], BLOCKS[:TUNED_FROM]):
        x = _run_block(x, layers, block)
    return x


def tuned_part(network, classes, rng):
    """The trained part's start: the last blocks, the head and a new linear layer."""
    return {"blocks": network["blocks"][TUNED_FROM:], "head": network["head"],
            "linear": {"w": rng.normal(0, 0.01, (classes, 1280)).astype(np.float32),
                       "b": np.zeros(classes, np.float32)}}


def logits(tuned, maps):
    x = maps
    for layers, block in zip(tuned["blocks"], BLOCKS[TUNED_FROM:]):
        x = _run_block(x, layers, block)
    x = _relu6(_pointwise(x, tuned["head"])).mean((1, 2))
    return x @ tuned["linear"]["w"].T + tuned["linear"]["b"]
