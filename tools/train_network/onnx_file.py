"""Networks as ONNX that OpenCV 4.6 reads: input `image` [1, 3, 128, 128], RGB in
0..255; output `probabilities` [1, classes]."""

import numpy as np
import onnx
from onnx import helper, numpy_helper

import network
from augment import INPUT_PX

OPSET = 10  # Pad and Clip with attributes


class Graph:
    def __init__(self):
        self.nodes, self.constants = [], []

    def constant(self, value):
        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(value, np.float32), name))
        return name

    def add(self, kind, inputs, output=None, **attributes):
        output = output or f"n{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [output], **attributes))
        return output

    def integers(self, value):
        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(value, np.int64), name))
        return name

    def connected(self, x, weight, bias):
        return self.add("Gemm", [x, self.constant(weight), self.constant(bias)], transB=1)

    def convolution(self, x, layer, size, stride=1, group=1, relu=True):
        kernel = layer["w"].shape[2]
        before, after = network.padding(size, kernel, stride)
        pads = [before, before, after, after]
        if before != after:
            x = self.add("Pad", [x], mode="constant", value=0.0, pads=[0, 0, before, before,
                                                                       0, 0, after, after])
            pads = [0, 0, 0, 0]
        y = self.add("Conv", [x, self.constant(layer["w"]), self.constant(layer["b"])],
                     kernel_shape=[kernel, kernel], strides=[stride, stride], pads=pads,
                     group=group)
        return self.add("Clip", [y], min=0.0, max=6.0) if relu else y

    def save(self, path, name, scores, classes):
        """With `scores` made probabilities."""
        self.add("Softmax", [scores], "probabilities", axis=1)
        value = helper.make_tensor_value_info
        model = helper.make_model(
            helper.make_graph(self.nodes, name,
                              [value("image", onnx.TensorProto.FLOAT, [1, 3, INPUT_PX, INPUT_PX])],
                              [value("probabilities", onnx.TensorProto.FLOAT, [1, classes])],
                              self.constants),
            opset_imports=[helper.make_opsetid("", OPSET)], ir_version=5)
        onnx.checker.check_model(model)
        onnx.save(model, path)


def write(path, pretrained, tuned, temperature):
    graph = Graph()
    scale = (1 / network.DEVIATION).reshape(1, 3, 1, 1)
    x = graph.add("Mul", ["image", graph.constant(scale)])
    x = graph.add("Add", [x, graph.constant(-network.MEAN.reshape(1, 3, 1, 1) * scale)])
    size = INPUT_PX
    x = graph.convolution(x, pretrained["stem"], size, stride=2)
    size //= 2
    blocks = pretrained["blocks"][:network.TUNED_FROM] + tuned["blocks"]
    for layers, block in zip(blocks, network.BLOCKS):
        y = graph.convolution(x, layers["expand"], size) if block.expand else x
        y = graph.convolution(y, layers["depthwise"], size, block.stride,
                              group=layers["depthwise"]["w"].shape[0])
        size //= block.stride
        y = graph.convolution(y, layers["project"], size, relu=False)
        x = graph.add("Add", [x, y]) if block.residual else y
    x = graph.convolution(x, tuned["head"], size)
    x = graph.add("Flatten", [graph.add("GlobalAveragePool", [x])], axis=1)
    weight, bias = (tuned["linear"][name] / temperature for name in "wb")
    graph.save(path, "efficientnet_lite0", graph.connected(x, weight, bias), len(bias))
