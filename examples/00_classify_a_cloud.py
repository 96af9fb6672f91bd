"""A file in metres in, a name out, whatever the yaw of the object in it.

python examples/00_classify_a_cloud.py chair.ply    # or without a file: a chair of our own
"""

import sys
from pathlib import Path

import numpy as np

import circumspect as cs


def main(arguments: list[str]) -> None:
    """Name one file, turned by four angles."""
    file = Path(arguments[0] if arguments else "chair.ply")
    if not arguments:
        cs.write_ply(file, cs.make_furniture("chair", 3).sampled(20_000, rng=0))

    cloud = cs.read_cloud(file)
    classifier = cs.Classifier.load()
    for yaw_deg in (0.0, 45.0, 100.0, 222.5):
        prediction = classifier.classify(cloud.turned(np.radians(yaw_deg)), metric=True)
        ranked = sorted(prediction.probabilities.items(), key=lambda entry: -entry[1])[:3]
        shares = ", ".join(f"{name} {probability:.3f}" for name, probability in ranked)
        print(f"turned by {yaw_deg:5.1f} deg: {prediction.text}; {shares}")
        if not prediction.confident:
            print(f"    not confident: {prediction.reason}")


if __name__ == "__main__":
    main(sys.argv[1:])
