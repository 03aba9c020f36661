"""spoil: push the free nodes of a good mesh about until its worst element is as bad as asked."""
import numpy as np
from scipy.optimize import brentq

from simplices import radius_ratios, volumes


def spoil(points, free, elements, direction, worst):
    """points + t direction at the free nodes, with the first t > 0 at which the largest radius
    ratio is worst; None if an element inverts before."""
    def moved(t):
        result = points.copy()
        result[free] += t * direction
        return result

    def excess(t):
        here = moved(t)
        if volumes(here, elements).min() <= 0:
            return np.inf
        return radius_ratios(here, elements).max() - worst

    step = 1e-3
    t = step
    while excess(t) < 0:
        t += step
    if not np.isfinite(excess(t)):
        low, high = t - step, t
        while high - low > 1e-14 and not (excess(high) > 0 and np.isfinite(excess(high))):
            middle = (low + high) / 2
            low, high = (middle, high) if excess(middle) < 0 else (low, middle)
        t = high
        if not np.isfinite(excess(t)):
            return None
        step = high - low
    return moved(brentq(excess, t - step, t, xtol=1e-16))
