"""model: predict the time of more processes from the figures of bench/distributed/run.

   model.py FOLDER RESULT.json

A sweep over N free nodes on p processes takes, with C colours,

    v N/p   the visits, v seconds each
  + C k l  for the messages: k neighbours, l seconds of latency for each
  + b s/B   bytes of the s nodes on the surface of a part, over the bandwidth
  + r g     r sums of all processes of g seconds, that grow as log2 p

s = c (N/p)^(2/3): c from what was sent. Printed as Markdown."""
import glob
import json
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), ".."))
import machine

ENTRY = 29  # bytes of a node in a message: position, three doubles, whether neighbours look again
NEIGHBOURS = 14  # of a part that is surrounded by others of its size
# Networks are slower than the memory that processes of one machine share: those of a cluster, from
# data sheets, not measured: 2 us, 5 GB/s for each process.
CLUSTER = {"latency": 2e-6, "bandwidth": 5e9}


def runs(folder, name):
    found = []
    for path in sorted(glob.glob(os.path.join(folder, f"{name}.*.json"))):
        with open(path) as file:
            found.append(json.load(file))
    return found


def sweeps_seconds(run):
    return sum(sweep["seconds"] for sweep in run["sweeps"])


def best(all_runs):
    return min(all_runs, key=sweeps_seconds)


def sweep_seconds(model, nodes, p, latency, bandwidth, sum_seconds):
    """Seconds of a sweep, and of each of its parts."""
    part = nodes / p
    surface = model["surface"] * part ** (2 / 3) if p > 1 else 0
    return {
        "visits": model["visit"] * part,
        "latency": model["colours"] * NEIGHBOURS * latency if p > 1 else 0,
        "bytes": surface * ENTRY / bandwidth,
        "sums": model["sums_per_sweep"] * sum_seconds * math.log2(p) if p > 1 else 0,
    }


def fit(alone, together):
    run = best(alone)
    visits = sum(sweep["visits"] for sweep in run["sweeps"])
    n_sweeps = len(run["sweeps"])
    # Node values that all processes send: each of p of them its surface, in every full sweep.
    ratios = []
    for p, r in together.items():
        if p > 1:
            part = r["mesh"]["free_nodes"] / p
            sent_per_node = r["processes"]["node_values"] / visits
            ratios.append(sent_per_node * part / part ** (2 / 3))
    colours = run["mesh"]["colours"]
    two = together[2]
    # One message to each neighbour for each colour; the rest of what is counted are sums.
    sums = (two["processes"]["messages"] / 2 - n_sweeps * colours) / n_sweeps
    return {
        "visit": sweeps_seconds(run) / visits,
        "surface": max(ratios),
        "colours": colours,
        "sums_per_sweep": max(sums, 0),
    }


def main():
    folder, result_path = sys.argv[1:]
    alone, one, two, from_h5 = (runs(folder, name) for name in ("alone", "1", "2", "h5"))
    with open(os.path.join(folder, "messages.json")) as file:
        messages = json.load(file)
    together = {1: best(one), 2: best(two)}
    for p in (3, 4, 8):
        together[p] = runs(folder, p)[0]
    model = fit(alone, together)
    a, b, c = (sweeps_seconds(best(r)) for r in (alone, one, two))
    mesh = best(alone)["mesh"]
    print(f"{machine.line(machine.description())}; {mesh['elements']:,} elements, "
          f"{mesh['free_nodes']:,} free nodes, {len(best(alone)['sweeps'])} sweeps.\n")
    print("| | sweeps, s | set-up, s | |\n|---|---|---|---|")
    setup = lambda r: best(r)["seconds"]["setup"]
    print(f"| `planish smooth -j 1` | {a:.3f} | {setup(alone):.2f} | |")
    print(f"| `planish-mpi`, 1 process | {b:.3f} | {setup(one):.2f} | {100 * (b / a - 1):+.1f} % |")
    print(f"| `planish-mpi`, 2 processes | {c:.3f} | {setup(two):.2f} | {b / c:.2f} times 1 process |")
    print(f"| the same, from and to PETSc's `.h5`, in parts | {sweeps_seconds(best(from_h5)):.3f} | {setup(from_h5):.2f} | |\n")
    print("| processes | messages | node values | bytes | longest wait, s |\n|---|---|---|---|---|")
    for p, r in together.items():
        t = r["processes"]
        wait = f"{t['longest_wait_seconds']:.3f}" if p <= 2 else "-"
        print(f"| {p} | {t['messages']:,} | {t['node_values']:,} | {t['bytes']:,} | {wait} |")
    print(f"\nA message here: {messages['latency'] * 1e6:.2f} us and {messages['bandwidth'] / 1e9:.1f} GB/s; "
          f"a sum of both processes {messages['sum'] * 1e6:.2f} us. "
          f"The model: v = {model['visit'] * 1e6:.2f} us, c = {model['surface']:.1f}, C = {model['colours']}, "
          f"{model['sums_per_sweep']:.1f} sums a sweep.\n")
    print("| elements | cores | machine | sweep, ms | visits | latency | bytes | sums | efficiency |")
    print("|---|---|---|---|---|---|---|---|---|")
    share = mesh["free_nodes"] / mesh["elements"]
    here = (messages["latency"], messages["bandwidth"], messages["sum"])
    cluster = (CLUSTER["latency"], CLUSTER["bandwidth"], 2 * CLUSTER["latency"])
    cases = [(mesh["elements"], 2, "this one", here), (1e8, 100, "cluster", cluster), (1e9, 1000, "cluster", cluster),
             (1e9, 10000, "cluster", cluster), (1e6, 1000, "cluster", cluster)]
    table = []
    for elements, p, name, costs in cases:
        parts = sweep_seconds(model, elements * share, p, *costs)
        total = sum(parts.values())
        table.append({"elements": elements, "processes": p, "machine": name, "seconds": parts})
        cells = " | ".join(f"{1e3 * parts[key]:.3g}" for key in ("visits", "latency", "bytes", "sums"))
        print(f"| {elements:.3g} | {p} | {name} | {1e3 * total:.3g} | {cells} | {100 * parts['visits'] / total:.1f} % |")
    measured = 1e3 * c / len(best(two)["sweeps"])
    print(f"\nMeasured on 2 processes here: {measured:.3g} ms a sweep.")
    with open(result_path, "w") as file:
        json.dump({"machine": machine.description(), "mesh": mesh, "model": model, "messages": messages,
                   "sweeps_seconds": {"alone": a, "1": b, "2": c}, "table": table,
                   "processes": {p: r["processes"] for p, r in together.items()}}, file, indent=1)


main()
