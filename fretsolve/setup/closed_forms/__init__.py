"""The closed forms that a case has. In come the case and its model, out come values with their sources, or none.

from fretsolve.setup.closed_forms.area_forms import ClosedForms
forms = ClosedForms(case, model)
forms.largest, list(forms.values())
"""
