"""A crack that begins in fretting: does it stop, and if not, how long does it take?

In come the tractions and bulk stresses of a result, and constants of the material; out come the stress intensities of a
crack normal to the surface over its length, its range beside the threshold, the length at which it stops, and lives,
with error bars. For example::

    with open_result("case.h5") as result:
        crack = crack_of(TractionHistory(result), CrackRequest(read_material("aluminium.yaml")))
        write_crack(crack, result, Path("case.crack.h5"))
"""
