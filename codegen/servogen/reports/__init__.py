"""The report: one HTML file with everything a design review asks for."""

from servogen.reports.contour_data import ContourReportData
from servogen.reports.contour_page import make_contour_report
from servogen.reports.data import ReportData
from servogen.reports.governor_data import GovernorReportData
from servogen.reports.governor_page import make_governor_report
from servogen.reports.servo_data import ServoReportData
from servogen.reports.servo_page import make_servo_report
from servogen.reports.two_stage_page import make_report

__all__ = [
    "ContourReportData",
    "GovernorReportData",
    "ReportData",
    "ServoReportData",
    "make_contour_report",
    "make_governor_report",
    "make_report",
    "make_servo_report",
]
