"""show: the results of peers.py as Markdown."""

COLUMNS = ("method", "s", "worst RR", "smallest angle", "RMS of RR", "inverted",
           "planish to this RMS", "times faster", "with set-up")


def machine(results):
    versions = ", ".join(" ".join(pair) for pair in results["versions"].items())
    print(f"{versions}; {results['cpu']}, {results['cores']} cores; {results['date']}\n")


def table(found):
    """Of one mesh."""
    print("{mesh}: {elements} tetrahedra, {free_nodes} of {nodes} nodes free; planish's set-up "
          "{setup_seconds:.3f} s\n".format(**found))
    line(COLUMNS)
    line(("---", *["--:"] * (len(COLUMNS) - 1)))
    for row in found["rows"]:
        cells = [row["method"], *(failure(row) if "failed" in row else (*figures(row), *lead(row)))]
        line(cells + [""] * (len(COLUMNS) - len(cells)))
    print(flush=True)


def line(cells):
    print(f"| {' | '.join(cells)} |")


def failure(row):
    return (f"failed: {row['failed']}",)


def figures(row):
    seconds = f"{row['seconds']:.3f}" if "seconds" in row else ""
    return (seconds, f"{row['max_radius_ratio']:.4g}", f"{row['min_dihedral_deg']:.3g}",
            f"{row['rms_radius_ratio']:.4f}", str(row["inverted"]))


def lead(row):
    """The last three columns, or as many of them as there is something to say in."""
    if "planish" not in row:
        return ()
    planish = row["planish"]
    if planish is None:
        return ("never",)
    if planish["sweeps"] == 0:
        return ("no better than the mesh",)
    plural = "s" * (planish["sweeps"] > 1)
    return (f"{planish['seconds']:.3f} s, {planish['sweeps']} sweep{plural}",
            f"{planish['times_faster']:.1f}", f"{planish['times_faster_with_setup']:.1f}")
