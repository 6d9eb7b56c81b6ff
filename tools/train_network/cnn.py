"""CNN 1, 2 and 3 of Hoseini 2021, 5.3, in JAX: dropout, convolution, dropout, convolution, pooling,
then three layers that connect all, with dropout before the first two of these.

What the paper leaves open is as in its authors' configuration: 5 x 5 windows, 3 and then 2 filters,
2 x 2 pools, 800 and 150 units, images normalised to mean 0 and deviation 1 one by one. The weight of
the activities' squares is ours.
"""

import collections

import jax
import jax.numpy as jnp
import numpy as np
import optax

import onnx_file
from augment import INPUT_PX

Kind = collections.namedtuple("Kind", "convolutions rectified")
KINDS = {"cnn1": Kind(2, True),   # rectified linear units, the maximum of each pool
         "cnn2": Kind(2, False),  # hyperbolic tangent, the mean of each pool
         "cnn3": Kind(1, True)}   # as CNN 1, without the second convolution and what follows it
KERNEL, FILTERS, HIDDEN = 5, (3, 2), (800, 150)
DROPOUT, ACTIVITY = 0.1, 1e-4
BATCH, RATE, DECAY = 50, 0.01, 0.95  # the rate goes down by DECAY with each epoch
PATIENCE = 20  # epochs without a smaller loss on the images kept out
EPSILON = 1e-5


def initial(kind, classes, rng):
    """Layers of weights and biases, the convolutions first; variances as the units want them (He,
    Glorot)."""
    gain = 2.0 if KINDS[kind].rectified else 1.0

    def layer(*shape):
        deviation = np.sqrt(gain / np.prod(shape[1:]))
        return {"w": rng.normal(0, deviation, shape).astype(np.float32),
                "b": np.zeros(shape[0], np.float32)}
    side, channels, layers = INPUT_PX, 3, []
    for filters in FILTERS[:KINDS[kind].convolutions]:
        layers.append(layer(filters, channels, KERNEL, KERNEL))
        side, channels = side - KERNEL + 1, filters
    if KINDS[kind].convolutions == 2:
        side //= 2
    inputs = side * side * channels
    for units in (*HIDDEN, classes):
        layers.append(layer(units, inputs))
        inputs = units
    return layers


def logits(layers, images, kind, key=None):
    """Of images [batch, height, width, 3] in 0..255, and the sum of the activities' mean squares. With
    a `key` some units drop out."""
    active = jax.nn.relu if kind.rectified else jnp.tanh
    keys = iter(jax.random.split(key, 5)) if key is not None else None
    activity = 0.0

    def dropped(x):
        if keys is None:
            return x
        return x * jax.random.bernoulli(next(keys), 1 - DROPOUT, x.shape) / (1 - DROPOUT)
    x = jnp.transpose(images, (0, 3, 1, 2))
    x = x - x.mean((1, 2, 3), keepdims=True)
    x = x / jnp.sqrt((x * x).mean((1, 2, 3), keepdims=True) + EPSILON)
    for layer in layers[:kind.convolutions]:
        x = jax.lax.conv_general_dilated(dropped(x), layer["w"], (1, 1), "VALID")
        x = active(x + layer["b"][:, None, None])
        activity += (x * x).mean()
    if kind.convolutions == 2:
        batch, channels, height, width = x.shape
        pools = x.reshape(batch, channels, height // 2, 2, width // 2, 2)
        x = pools.max((3, 5)) if kind.rectified else pools.mean((3, 5))
    x = x.reshape(len(x), -1)
    for layer in layers[kind.convolutions:-1]:
        x = active(dropped(x) @ layer["w"].T + layer["b"])
        activity += (x * x).mean()
    return x @ layers[-1]["w"].T + layers[-1]["b"], activity


def scores(layers, images, name):
    """The logits of many images, uint8."""
    run = jax.jit(lambda x: logits(layers, x, KINDS[name])[0])
    return np.concatenate([np.asarray(run(np.float32(images[i:i + BATCH])))
                           for i in range(0, len(images), BATCH)])


def train(name, classes, images, labels, held_out, held_out_labels, epochs, rng):
    """The layers of the epoch with the least cross entropy on the images kept out, or of the last
    where none are."""
    kind, layers = KINDS[name], initial(name, classes, rng)
    steps = len(labels) // BATCH
    if steps == 0:
        raise SystemExit(f"train_network: {len(labels)} images; a batch needs {BATCH}")
    optimiser = optax.adam(optax.exponential_decay(RATE, steps, DECAY))
    # Each class counts alike, however many images it has.
    weight = jnp.asarray(len(labels) / (classes * np.bincount(labels, minlength=classes)))

    @jax.jit
    def step(layers, state, x, y, key):
        def loss(layers):
            found, activity = logits(layers, x.astype(jnp.float32), kind, key)
            entropy = optax.softmax_cross_entropy_with_integer_labels(found, y)
            return (weight[y] * entropy).mean() + ACTIVITY * activity
        value, gradient = jax.value_and_grad(loss)(layers)
        update, state = optimiser.update(gradient, state)
        return optax.apply_updates(layers, update), state, value

    state, key = optimiser.init(layers), jax.random.key(int(rng.integers(2**31)))
    best, least, since = layers, np.inf, 0
    for epoch in range(epochs):
        order, losses = rng.permutation(len(labels)), []
        for i in range(steps):
            batch = order[i * BATCH:(i + 1) * BATCH]
            key, own = jax.random.split(key)
            layers, state, value = step(layers, state, images[batch], labels[batch], own)
            losses.append(float(value))
        if not len(held_out):
            best = layers
            continue
        found = optax.softmax_cross_entropy_with_integer_labels(
            jnp.asarray(scores(layers, held_out, name)), held_out_labels).mean()
        print(f"epoch {epoch + 1} of {epochs}: loss {np.mean(losses):.3f}, held out {found:.3f}",
              flush=True)
        since += 1
        if found < least:
            best, least, since = layers, found, 0
        if since == PATIENCE:
            break
    return best


def write(path, name, layers, temperature):
    kind, graph = KINDS[name], onnx_file.Graph()
    active = "Relu" if kind.rectified else "Tanh"
    flat = graph.add("Reshape", ["image", graph.integers([1, 1, 3 * INPUT_PX, INPUT_PX])])
    x = graph.add("InstanceNormalization", [flat, graph.constant([1.0]), graph.constant([0.0])],
                  epsilon=EPSILON)
    x = graph.add("Reshape", [x, graph.integers([1, 3, INPUT_PX, INPUT_PX])])
    for layer in layers[:kind.convolutions]:
        x = graph.add("Conv", [x, graph.constant(layer["w"]), graph.constant(layer["b"])],
                      kernel_shape=[KERNEL, KERNEL])
        x = graph.add(active, [x])
    if kind.convolutions == 2:
        x = graph.add("MaxPool" if kind.rectified else "AveragePool", [x], kernel_shape=[2, 2],
                      strides=[2, 2])
    x = graph.add("Flatten", [x], axis=1)
    for layer in layers[kind.convolutions:-1]:
        x = graph.add(active, [graph.connected(x, layer["w"], layer["b"])])
    x = graph.connected(x, layers[-1]["w"] / temperature, layers[-1]["b"] / temperature)
    graph.save(path, name, x, len(layers[-1]["b"]))
