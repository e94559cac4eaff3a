"""A* along a course among balls: the search of `pilots/astar.py`, one node at a time.

The ship's step is the asteroid field's own (turn, then fly on); a test holds the two together.
Balls are found through cubes as wide as a ball's reach, each with a list of those in it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

NODES, WAITING, EXPANDED, FARTHEST, GOAL = range(5)
"""What `counts` counts: nodes made, nodes in the open list, nodes expanded; and the numbers of the
node farthest ahead, and of the goal, -1 until it is found."""
COUNTS = 5
X, Y, Z, YAW, PITCH, COST, KEY = range(7)
"""Columns of `nodes`."""
COLUMNS = 7
PARENT, MOVE, WAYS = range(3)
"""Columns of `links`; the last is the number of decisions from the start."""
LINKS = 3
AHEAD = 1e-9
"""Seconds of advantage per decision from the start: of equals the farther goes first."""


@njit(cache=True, nogil=True, error_model="numpy")
def list_balls(balls, low, size, shape, heads, following):
    """Put every ball into the list of its cube; balls outside the cubes are left out."""
    heads[:] = -1
    for ball in range(len(balls)):
        cell = 0
        inside = True
        for axis in range(3):
            place = math.floor((balls[ball, axis] - low[axis]) / size)
            inside = inside and 0 <= place < shape[axis]
            cell = cell * shape[axis] + place
        if inside:
            following[ball] = heads[cell]
            heads[cell] = ball


@njit(cache=True, nogil=True, error_model="numpy")
def touches(x, y, z, balls, reach, low, size, shape, heads, following):
    """Whether a point is nearer than `reach`, at most `size` / 2, to the middle of a ball."""
    i, j, k = (x - low[0]) / size - 0.5, (y - low[1]) / size - 0.5, (z - low[2]) / size - 0.5
    first, second, third = math.floor(i), math.floor(j), math.floor(k)
    for a in range(max(first, 0), min(first + 2, shape[0])):
        for b in range(max(second, 0), min(second + 2, shape[1])):
            for c in range(max(third, 0), min(third + 2, shape[2])):
                ball = heads[(a * shape[1] + b) * shape[2] + c]
                while ball >= 0:
                    dx, dy, dz = balls[ball, 0] - x, balls[ball, 1] - y, balls[ball, 2] - z
                    if dx * dx + dy * dy + dz * dz < reach * reach:
                        return True
                    ball = following[ball]
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def push(heap, size, nodes, number):
    """Put a node into the binary heap `heap`, which is in order of KEY."""
    place = size
    key = nodes[number, KEY]
    while place > 0:
        above = (place - 1) // 2
        if nodes[heap[above], KEY] <= key:
            break
        heap[place] = heap[above]
        place = above
    heap[place] = number


@njit(cache=True, nogil=True, error_model="numpy")
def pop(heap, size, nodes):
    """Take the node of the least KEY out of the heap of `size` nodes."""
    best = heap[0]
    last = heap[size - 1]
    size -= 1
    key = nodes[last, KEY]
    place = 0
    while True:
        below = 2 * place + 1
        if below >= size:
            break
        if below + 1 < size and nodes[heap[below + 1], KEY] < nodes[heap[below], KEY]:
            below += 1
        if nodes[heap[below], KEY] >= key:
            break
        heap[place] = heap[below]
        place = below
    heap[place] = last
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def known(nodes, number, merge, merge_rad, table, places):
    """Whether a node as good or better stands where this one does; else it is noted as the best.

    `table` is a hash table of node numbers, -1 where empty; `places` (entries, 5) says where.
    """
    mask = len(table) - 1
    cell = np.empty(5, np.int64)
    mixed = np.uint64(1469598103934665603)
    for axis in range(5):
        width = merge if axis < 3 else merge_rad
        cell[axis] = math.floor(nodes[number, axis] / width + 0.5)
        mixed = (mixed ^ np.uint64(cell[axis])) * np.uint64(1099511628211)
        mixed = mixed ^ (mixed >> np.uint64(29))
    slot = np.int64(mixed & np.uint64(mask))
    while table[slot] >= 0:
        same = True
        for axis in range(5):
            same = same and places[slot, axis] == cell[axis]
        if same:
            if nodes[table[slot], COST] <= nodes[number, COST]:
                return True
            table[slot] = number
            return False
        slot = (slot + 1) & mask
    table[slot] = number
    places[slot] = cell
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def expand(
    nodes, links, heap, table, places, counts, limit,
    balls, low, size, shape, heads, following,
    moves, hold, advance, dt_s, reach, half, steepest, goal_x, merge, merge_rad,
):  # fmt: skip
    """Go on with the search until the goal is reached, nothing is left, or `limit` nodes expanded.

    Node 0 must be in the heap at the beginning. The cost is time; what is left to do is the
    straight way to the plane x = `goal_x`, which no ship can undercut.
    """
    speed = advance / dt_s
    room = len(nodes) - len(moves)
    while counts[WAITING] > 0 and counts[EXPANDED] < limit and counts[NODES] <= room:
        here = pop(heap, counts[WAITING], nodes)
        counts[WAITING] -= 1
        if nodes[here, X] >= goal_x:
            counts[GOAL] = here
            return
        counts[EXPANDED] += 1
        for move in range(len(moves)):
            x, y, z = nodes[here, X], nodes[here, Y], nodes[here, Z]
            yaw, pitch = nodes[here, YAW], nodes[here, PITCH]
            steps = 0
            clear = True
            while steps < hold and clear and x < goal_x:
                yaw = min(max(yaw + moves[move, 0], -steepest), steepest)
                pitch = min(max(pitch + moves[move, 1], -steepest), steepest)
                flat = math.cos(pitch)
                x += flat * math.cos(yaw) * advance
                y += flat * math.sin(yaw) * advance
                z += math.sin(pitch) * advance
                steps += 1
                clear = abs(y) <= half and abs(z) <= half
                clear = clear and not touches(
                    x, y, z, balls, reach, low, size, shape, heads, following
                )
            if not clear:
                continue
            made = counts[NODES]
            nodes[made, X], nodes[made, Y], nodes[made, Z] = x, y, z
            nodes[made, YAW], nodes[made, PITCH] = yaw, pitch
            nodes[made, COST] = nodes[here, COST] + steps * dt_s
            ways = links[here, WAYS] + steps
            left = max(goal_x - x, 0.0) / speed
            nodes[made, KEY] = nodes[made, COST] + left - AHEAD * ways
            if merge > 0.0 and known(nodes, made, merge, merge_rad, table, places):
                continue
            links[made, PARENT], links[made, MOVE], links[made, WAYS] = here, move, ways
            counts[NODES] += 1
            push(heap, counts[WAITING], nodes, made)
            counts[WAITING] += 1
            if x > nodes[counts[FARTHEST], X]:
                counts[FARTHEST] = made
