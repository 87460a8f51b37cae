"""The report: one HTML file with everything a design review asks for."""

from servogen.reports.data import ReportData
from servogen.reports.two_stage_page import make_report

__all__ = ["ReportData", "make_report"]
