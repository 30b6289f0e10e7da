"""Control: drives that solve a task, found by gradients, by evolution, by reinforcement learning.

`drive.py` turns a few numbers into an action for every control step; `study/` lets methods search for the best ones at an equal
budget of physics. The studies that come with the package lie in `studies/`.
"""
