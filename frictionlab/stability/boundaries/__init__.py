"""Where stability changes, and what begins there.

Along one parameter: `sign_changes` brackets the changes of sign of the sorted growth rates,
`stability_changes` solves for them and names them.  `first_losses` does so on thousands of lines.  In
a plane of two: `stability_map` evaluates a grid, finds the curves between its points and follows them.
`hopf` computes the normal form at a flutter point.
"""
