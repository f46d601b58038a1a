"""The specimens, how each is moved, and what is hidden in them."""

EFFECTS = """none contact-offset sync-delay permanent-set backlash elastic-stiffening mullins cyclic-softening thermal-stiffness fast-mode
slow-relaxation coulomb-friction load-friction viscous-drag rate-drag inertia drift warm-up thermal-output gauge-nonlinearity saturation
sensor-lag mains-hum zero-shift""".split()
# Arguments of `palpate fit` that name the law of each specimen.
LAWS = {
    "elastic": ["fung", "--relaxation", "none"],
    "springpot": ["fung", "--relaxation", "power-law"],
    "rubber": ["fung", "--elastic", "neo-hooke", "--separation", "bonded"],
    "springs": ["generalized-maxwell", "--separation", "bonded"],
    "damped": ["kelvin-voigt", "--separation", "bonded"],
}
# How each is moved.
MOTIONS = {
    "elastic": ["presses"],
    "springpot": ["presses"],
    "rubber": ["pulls"],
    "springs": ["pulls", "swings"],
    "damped": ["pulls", "swings"],
}
