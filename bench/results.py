"""results: what the programs that show results have in common."""
import json

import machine


def load(path):
    with open(path) as file:
        return json.load(file)


def save_plot(figure, axes, about, path):
    """Write a figure with its axes, and what it was measured on above them."""
    for one in axes:
        one.grid(alpha=0.3)
    figure.suptitle(machine.line(about), fontsize="small")
    figure.tight_layout()
    figure.savefig(path)
